//! ST's B-G431B-ESC1: STM32G431CB, three half bridges with shunts, CAN transceiver, connector for
//! an encoder or Hall sensors. docs/hardware.md has its wiring, and what was never tried.
//!
//! * `analogue`: zero, scale and thresholds from the resistors
//! * `bridge`: TIM1, its outputs and what opens them
//! * `over_current`: comparators that open the bridge without software
//! * `sampling`: op-amps and converters, and the current interrupt
//! * `encoder`: TIM4 counts the encoder
//! * `halls`: reads Hall sensors on the encoder's pads
//! * `transceiver`: the CAN transceiver and the board's terminator
//! * `shaft_sensor`: absolute sensor at the output shaft, on the pads of the limit switches
//! * `switches`: home and limit switches
//! * `image`: header of the program
//! * `limits`: bounds of the settings
//! * `thermistor`: converts the temperature
//!
//! The rest is in [`super::stm32g4`].
//!
//! Interrupts, most urgent first: current loop, clock, bus, control task. All other tasks run in
//! the thread.

mod analogue;
mod bridge;
mod encoder;
mod halls;
mod image;
mod limits;
mod over_current;
mod sampling;
mod shaft_sensor;
mod switches;
mod thermistor;
mod transceiver;

use super::stm32g4::{can, clock, led, reset, stack_guard, storage};
use crate::boards::Board;
use crate::refusal::refuse;
use crate::roles::{self, Role, Spawners};
use defmt_rtt as _;
use embassy_executor::{Executor, InterruptExecutor, Spawner};
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::rcc::PllPreDiv;
use static_cell::StaticCell;
use tautrack::bus::node::Condition;
use tautrack::fault_log::FaultLog;
use tautrack::math::Crc32;
use tautrack::motor::board_limits::Limit;
use tautrack::motor::bridge::{BridgeStop, Ratings};
use tautrack::motor::rotor::RotorSensor;
use tautrack::motor::shaft_sensor::{Kind, Reading};
use tautrack::sensors::{Switches, Temperatures};
use tautrack::settings::{Setting, Settings};

/// The motor board.
pub struct Esc1;

/// Header of the image, to which `cargo flash-node` adds length and checksum.
#[used]
#[unsafe(link_section = ".image_header")]
static HEADER: [u32; 4] = [image::MAGIC, 0, 0, 0];

/// Executor of the control task. It runs in the interrupt of a peripheral that the board does not
/// use.
static CONTROL: InterruptExecutor = InterruptExecutor::new();

#[interrupt]
unsafe fn USART3() {
    // SAFETY: only this interrupt, with which the executor was started, calls this.
    unsafe { CONTROL.on_interrupt() }
}

/// Starts the peripherals and the tasks. `bus` is the executor of the thread.
#[inline(never)] // its stack is free again when the tasks run
fn start(role: &'static Role, bus: Spawner) {
    reset::start_watchdog();
    let p = clock::start();
    reset::report_cause();
    interrupt::TIM2.set_priority(Priority::P1);
    interrupt::FDCAN1_IT0.set_priority(Priority::P2);
    interrupt::FDCAN1_IT1.set_priority(Priority::P2);
    interrupt::USART3.set_priority(Priority::P3);

    storage::start(p.FLASH);
    let (settings, found) = crate::storage::load(&mut storage::Storage);
    // The index, or the third Hall sensor, takes the input of the home switch.
    let sensor = RotorSensor::of(&settings);
    let home = if sensor.is_some_and(RotorSensor::has_halls) {
        encoder::start_halls(p.PB6, p.PB7, p.PB8);
        None
    } else {
        encoder::start(p.TIM4, p.PB6, p.PB7);
        if sensor == Some(RotorSensor::Indexed) {
            encoder::start_index(p.PB8);
            None
        } else {
            Some(p.PB8)
        }
    };
    let limits = match Kind::of(&settings).filter(|_| role.shaft_sensor) {
        Some(kind) => {
            shaft_sensor::spawn(bus, kind, p.PB3, p.PB4);
            None
        }
        None => Some((p.PB3, p.PB4)),
    };
    switches::start(home, limits);
    bridge::start(bridge::Pins {
        timer: p.TIM1,
        high: (p.PA8, p.PA9, p.PA10),
        low: (p.PC13, p.PA12, p.PB15),
        safe_torque_off: p.PA15,
        dead_time_ns: settings.get(Setting::DeadTime),
    });
    over_current::start(&settings);
    let pins = sampling::Pins {
        amplifiers: (p.OPAMP1, p.OPAMP2, p.OPAMP3),
        a: (p.PA1, p.PA3, p.PA2),
        b: (p.PA7, p.PA5, p.PA6),
        c: (p.PB0, p.PB2, p.PB1),
        converters: (p.ADC1, p.ADC2),
        supply: p.PA0,
        temperature: p.PB14,
    };
    sampling::start(pins, settings.si(Setting::OverVoltage));
    transceiver::start(p.PC11, p.PC14);
    let can = can::start(p.FDCAN1, p.PA11, p.PB9);

    let control = CONTROL.start(interrupt::USART3);
    can.spawn(bus);
    let spawners = Spawners { control, bus };
    let started = if !found.has_settings() {
        roles::start_blank(spawners, role, found)
    } else if !has_sensor(&settings) {
        Err(refuse(
            "rotor_sensor",
            "the board has no absolute rotor sensor",
        ))
    } else {
        (role.start)(spawners, &settings, found)
    };
    if let Err(refusal) = &started {
        defmt::error!("refused: {=str}", refusal);
    }
    led::spawn(bus, p.PC6, started.is_ok());
}

/// Whether the board has the rotor sensor of these settings: it counts an incremental encoder, or
/// reads Hall sensors.
fn has_sensor(settings: &Settings) -> bool {
    !matches!(
        RotorSensor::of(settings),
        Some(RotorSensor::Absolute | RotorSensor::Checked)
    )
}

impl Esc1 {
    /// Frequency of the crystal, Hz.
    pub(super) const CRYSTAL_HZ: u32 = 8_000_000;
    /// Divider that makes 4 MHz of it.
    pub(super) const CRYSTAL_DIVIDER: PllPreDiv = PllPreDiv::DIV2;

    /// Opens the bridge.
    pub(super) fn make_safe() {
        bridge::open();
    }

    /// Takes note that the last reset followed a failure.
    pub(super) fn note_crash() {
        bridge::note_crash();
    }

    /// Forgets an event of the processor that is over and harmless.
    pub(super) fn forget_event() {
        bridge::forget_event();
    }

    /// Whether a break input has opened the bridge.
    pub(super) fn stopped() -> bool {
        bridge::tripped()
    }
}

impl Board for Esc1 {
    const NAME: &'static str = "esc1";
    const POWER_STAGE: Ratings = Ratings {
        pwm_hz: bridge::PWM_HZ,
        period: bridge::PERIOD,
        highest: bridge::HIGHEST,
        sampled: bridge::SAMPLED,
        full_scale: analogue::FULL_SCALE_AMPERES,
        highest_supply: limits::HIGHEST_SUPPLY,
    };

    const LIMITS: &'static [Limit] = &limits::LIMITS;

    type Storage = storage::Storage;

    fn run(role: &'static Role, _: &'static [&'static Role]) -> ! {
        static EXECUTOR: StaticCell<Executor> = StaticCell::new();
        bridge::open();
        bridge::freeze_when_halted();
        stack_guard::start();
        EXECUTOR.init(Executor::new()).run(|bus| start(role, bus))
    }

    fn encoder() -> i32 {
        encoder::count()
    }

    fn encoder_broken() -> bool {
        halls::are_broken()
    }

    fn bridge_stop() -> Option<BridgeStop> {
        bridge::stop()
    }

    fn shaft_sensor() -> Reading {
        shaft_sensor::read()
    }

    fn index() -> Option<u32> {
        encoder::index()
    }

    fn kept_faults() -> FaultLog {
        reset::kept_faults()
    }

    fn keep_faults(log: &FaultLog) {
        reset::keep_faults(log);
    }

    fn set_over_current(limit: f32, zeros: [i32; 3]) {
        over_current::set_limit(limit, zeros);
    }

    fn supply_voltage() -> f32 {
        sampling::supply_voltage()
    }

    fn temperatures() -> Temperatures {
        Temperatures {
            bridge: Some(sampling::temperature()),
            motor: None,
        }
    }

    fn switches() -> Switches {
        switches::read()
    }

    fn set_brake(_released: bool) {}

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
