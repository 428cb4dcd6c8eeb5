//! ST's NUCLEO-G474RE with a CAN transceiver: STM32G474RE, board of the guard. docs/guard-board.md
//! has its wiring, and what was never tried.
//!
//! * `gnss`: serial line of the GNSS receiver
//! * `operator`: emergency stop and dead-man switch
//! * `sensors`: I2C bus of the sensor chips
//!
//! The rest is in [`super::stm32g4`]. Interrupts, most urgent first: clock, bus and GNSS receiver,
//! control task, I2C bus. All other tasks run in the thread.

mod gnss;
mod operator;
mod sensors;

use super::stm32g4::{can, clock, led, reset, stack_guard, storage};
use crate::boards::{Board, OperatorSwitches};
use crate::roles::{self, Role, Spawners};
use crate::sensors::{Published, Rates};
use defmt_rtt as _;
use embassy_executor::{Executor, InterruptExecutor, SpawnError, Spawner};
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::rcc::PllPreDiv;
use static_cell::StaticCell;
use tautrack::bus::node::Condition;
use tautrack::fault_log::FaultLog;
use tautrack::math::Crc32;
use tautrack::motor::bridge::Ratings;
use tautrack::sensors::Switches;

/// The guard's board.
pub struct G474;

/// Executor of the control task. It runs in the interrupt of a peripheral that the board does not
/// use.
static CONTROL: InterruptExecutor = InterruptExecutor::new();

#[interrupt]
unsafe fn USART3() {
    // SAFETY: only this interrupt, with which the executor was started, calls this.
    unsafe { CONTROL.on_interrupt() }
}

impl G474 {
    /// Frequency of the crystal, Hz.
    pub(super) const CRYSTAL_HZ: u32 = 24_000_000;
    /// Divider that makes 4 MHz of it.
    pub(super) const CRYSTAL_DIVIDER: PllPreDiv = PllPreDiv::DIV6;

    /// The board moves nothing. Its nodes hold when the guard is silent.
    pub(super) fn make_safe() {}

    /// Takes note that the last reset followed a failure: the log says so.
    pub(super) fn note_crash() {}

    /// Forgets an event of the processor: this board keeps none.
    pub(super) fn forget_event() {}

    /// Whether the emergency stop is actuated.
    pub(super) fn stopped() -> bool {
        operator::switches().emergency_stop
    }
}

impl Board for G474 {
    const NAME: &'static str = "g474";
    /// The board has no bridge.
    const POWER_STAGE: Ratings = Ratings {
        pwm_hz: 20_000,
        period: 1,
        highest: 1,
        sampled: 1,
        full_scale: 0.0,
        highest_supply: 0.0,
    };

    type Storage = storage::Storage;

    fn run(role: &'static Role, _: &'static [&'static Role]) -> ! {
        static EXECUTOR: StaticCell<Executor> = StaticCell::new();
        stack_guard::start();
        reset::start_watchdog();
        let p = clock::start();
        reset::report_cause();
        interrupt::TIM2.set_priority(Priority::P1);
        for line in [
            interrupt::FDCAN1_IT0,
            interrupt::FDCAN1_IT1,
            interrupt::USART1,
        ] {
            line.set_priority(Priority::P2);
        }
        interrupt::USART3.set_priority(Priority::P3);

        storage::start(p.FLASH);
        let (settings, found) = crate::storage::load(&mut storage::Storage);
        operator::start(p.PC10, p.PC12);
        sensors::start_bus(p.I2C3, p.PC8, p.PC9, p.DMA1_CH1, p.DMA1_CH2);
        let receiver = gnss::start(p.USART1, p.PC5);
        let can = can::start(p.FDCAN1, p.PA11, p.PA12);

        let control = CONTROL.start(interrupt::USART3);
        EXECUTOR.init(Executor::new()).run(|bus| {
            can.spawn(bus);
            let spawners = Spawners { control, bus };
            let started = if found.has_settings() {
                (role.start)(spawners, &settings, found)
            } else {
                roles::start_blank(spawners, role, found)
            };
            if receiver.is_err() {
                defmt::error!("no serial line");
            }
            if let Err(refusal) = &started {
                defmt::error!("refused: {=str}", refusal);
            }
            led::spawn(bus, p.PA5, started.is_ok());
        })
    }

    fn encoder() -> i32 {
        0
    }

    fn kept_faults() -> FaultLog {
        reset::kept_faults()
    }

    fn keep_faults(log: &FaultLog) {
        reset::keep_faults(log);
    }

    fn supply_voltage() -> f32 {
        0.0
    }

    fn switches() -> Switches {
        Switches::default()
    }

    fn operator_switches() -> OperatorSwitches {
        operator::switches()
    }

    fn set_brake(_released: bool) {}

    fn start_sensors(
        spawner: Spawner,
        rates: Rates,
        published: &'static Published,
    ) -> Result<(), SpawnError> {
        sensors::start(spawner, rates, published)
    }

    fn serial_number() -> u32 {
        Crc32::of(&embassy_stm32::uid::uid()).value()
    }

    fn storage() -> Self::Storage {
        storage::Storage
    }

    fn bus_condition() -> Condition {
        can::condition()
    }

    fn restart() {
        reset::restart();
    }

    fn feed_watchdog() {
        reset::feed_watchdog();
    }
}
