//! A model of the STM32G431 and the STM32G474 around rsemu's Cortex-M4F: as much of them as the
//! images of the boards use.
//!
//! Registers without a behaviour below keep what is written. Not modelled: bus contention, errors
//! of received frames and everything analogue.
//!
//! `breaks` has what opens the bridge without software.
//! `part` says what differs between the chips. `reset_values` has the registers after a reset.
//! `fdcan` is the CAN controller, `serial` a serial line, `i2c` an I2C bus with the sensor modules
//! on it, `dma` moves its bytes, `shaft_sensor` is a sensor on the motor board. `wait_states` is
//! the time for which the core waits for the flash memory. `observe` shows what tests measure, and
//! provokes what they need. `defect` gives the image a defect.

mod breaks;
mod defect;
mod dma;
mod fdcan;
mod flash_memory;
mod i2c;
mod observe;
mod part;
mod reset_values;
mod serial;
mod shaft_sensor;
mod wait_states;

pub use breaks::{Event, SYSCFG_CFGR2};
pub use defect::Defect;
pub use dma::{DMA1, DMA1_CHANNELS, DMAMUX1};
pub use fdcan::{BUS_OFF, CAN_ERRORS, CAN_STATUS, PASSIVE, Wiring};
pub use flash_memory::{Cut, FlashMemory, Tear};
pub use i2c::{I2C3, I2C3_ER, I2C3_EV, I2C3_REQUESTS, TIMINGR};
pub use observe::Executed;
pub use part::{Part, STM32G431, STM32G474};
pub use serial::USART1;
pub use shaft_sensor::{ShaftChip, ShaftSensor};

use super::motor::{AttachedMotor, Bridge, ZERO, supply_code};
use super::registers::Registers;
use crate::programs::flash::Segment;
use rsemu::core::space::{
    AccessConstraints, AddressSpace, Mapping, MemAttrs, MemOps, MemResult, Perms, RamStore, Region,
};
use rsemu::cpu::arm::v7m::sys::Exception;
use rsemu::cpu::arm::v7m::{ArmV7m, Config};
use std::collections::{BTreeSet, VecDeque};
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard};
use tautrack::can::Frame;
use tautrack::link::{BodyMeasurands, MotorModel, Sensors, Shaft};

/// Core clock after the start, Hz. The model's time counts these clocks.
pub const CORE_HZ: u64 = 170_000_000;
const FLASH: u32 = 0x0800_0000;
const RAM: u32 = 0x2000_0000;
/// Bits of the program status register that hold the state of an IT block.
const IT_STATE: u32 = 0x0600_fc00;
/// Contents of RAM that nothing was written to.
const PAINT: u8 = 0x5a;

/// Reset and clock control.
pub const RCC: u32 = 0x4002_1000;
/// Power control.
pub const PWR: u32 = 0x4000_7000;
/// Registers of the flash memory.
pub const FLASH_CONTROL: u32 = 0x4002_2000;
/// Timer of the bridge.
pub const TIM1: u32 = 0x4001_2c00;
/// Timer of the clock.
pub const TIM2: u32 = 0x4000_0000;
/// Watchdog.
pub const IWDG: u32 = 0x4000_3000;
/// CAN controller.
pub const FDCAN: u32 = 0x4000_6400;
/// Timer of the encoder.
const TIM4: u32 = 0x4000_0800;
const MESSAGES: u32 = 0x4000_a400;
const ADC: [u32; 2] = [0x5000_0000, 0x5000_0100];
/// Register of both converters that selects their clock (RM0440, 21.7.2).
pub const ADC_CONTROL: u32 = 0x5000_0308;
/// Ports, 0x400 bytes each.
pub const GPIO: u32 = 0x4800_0000;

/// Break and dead time register of [`TIM1`].
pub const BDTR: u32 = TIM1 + 0x44;
/// Main output enable in [`BDTR`].
pub const MOE: u32 = 1 << 15;

/// Number of the current interrupt.
pub const ADC1_2: u16 = 18;
/// Number of the CAN interrupt.
pub const FDCAN1_IT0: u16 = 21;
/// Number of the clock's interrupt.
pub const TIM2_IRQ: u16 = 28;
/// Number of the interrupt of [`USART1`].
pub const USART1_IRQ: u16 = 37;
/// Number of the control task's interrupt.
pub const CONTROL: u16 = 39;

/// Register write of the image.
#[derive(Clone, Copy, Debug)]
pub struct Write {
    /// Time, core clocks.
    pub clock: u64,
    /// Address of the register.
    pub address: u32,
    /// The word.
    pub value: u32,
}

/// Voltages and levels at the chip's pins.
#[derive(Clone, Copy, Debug)]
pub struct Pins {
    /// Voltages of the op-amps of phases a, b and c without current, V, if a motor is attached.
    pub zeros: [f32; 3],
    /// Code of the current of phase a.
    pub phase_a: u16,
    /// Code of the current of phase b.
    pub phase_b: u16,
    /// Code of the current of phase c.
    pub phase_c: u16,
    /// Code of the supply voltage.
    pub supply: u16,
    /// Code of the temperature.
    pub temperature: u16,
    /// Level of the input "safe torque off".
    pub safe_torque_off: bool,
    /// Levels of the comparators of phases a, b and c: over-current.
    pub over_current: [bool; 3],
    /// Supply voltage of the chip, V.
    pub chip_supply: f32,
    /// Levels of port B.
    pub port_b: u16,
    /// Levels of port C.
    pub port_c: u16,
}

#[derive(Default)]
struct State {
    part: Part,
    registers: Registers,
    writes: Vec<Write>,
    clock: u64,
    changed: bool,
    pins: Option<Pins>,
    received: VecDeque<Frame>,
    sent: Vec<(u64, Frame)>,
    /// Clock at which the watchdog resets the chip.
    watchdog: Option<u64>,
    /// Clocks at which the timers were started, and the last time they were advanced.
    tim1_start: u64,
    tim2_start: u64,
    advanced: u64,
    resets: u32,
    changed_while_live: u32,
    defect: Option<Defect>,
    /// Register writes are not kept.
    forgets_writes: bool,
    motor: Option<AttachedMotor>,
    events: breaks::Events,
    can: fdcan::Controller,
    flash: Option<FlashMemory>,
    serial: serial::Line,
    i2c: i2c::Controller,
    modules: Option<Box<i2c::Modules>>,
    shaft_sensor: Option<ShaftSensor>,
    moved: dma::Moved,
    /// Flash memory and RAM, as the DMA sees them.
    memories: Option<[Arc<RamStore>; 2]>,
}

impl State {
    fn reset(&mut self, watchdog: bool) {
        let values = self.part.reset_values();
        self.registers = Registers::new(values.map(|(_, address, value)| (address, value)));
        // The cause of the reset: the watchdog, or power-up (brown-out and pin).
        let cause = if watchdog { 0x2400_0000 } else { 0x0c00_0000 };
        self.set(RCC + 0x94, cause);
        self.watchdog = None;
        self.reset_events();
        self.can = self.can.after_reset();
        self.i2c = i2c::Controller::default();
        if let Some(flash) = &mut self.flash {
            flash.lock();
        }
        self.received.clear();
        self.changed = true;
    }

    fn flash(&mut self) -> &mut FlashMemory {
        self.flash.as_mut().expect("the chip has flash memory")
    }

    fn get(&self, address: u32) -> u32 {
        self.registers.get(address)
    }

    fn set(&mut self, address: u32, value: u32) {
        self.registers.set(address, value);
    }

    fn pins(&self) -> Pins {
        self.pins.expect("the chip has pins")
    }

    fn tim2_ticks(&self, clock: u64) -> u64 {
        (clock - self.tim2_start) / (u64::from(self.get(TIM2 + 0x28)) + 1)
    }

    fn read(&mut self, address: u32) -> u32 {
        if let Some(value) = self.read_serial(address).or_else(|| self.read_i2c(address)) {
            return value;
        }
        let value = self.get(address);
        match address {
            // Oscillators and the PLL are ready at once.
            RCC => {
                let ready = (value & 0x0101_0100) << 1 & self.ready_mask();
                value | ready | (value & 1 << 8) << 2
            }
            a if a == RCC + 0x08 => value & !0xc | (value & 3) << 2,
            a if a == RCC + 0x94 || a == RCC + 0x98 => value | (value & 1) << 1,
            a if a == FLASH_CONTROL + 0x10 => self.flash().status,
            a if a == FLASH_CONTROL + 0x14 => self.flash().control,
            a if a == IWDG + 0x0c => 0,
            a if a == TIM2 + 0x24 && self.get(TIM2) & 1 != 0 => {
                (self.tim2_ticks(self.clock) & 0xffff) as u32
            }
            a if a == TIM4 + 0x24 && self.counts_encoder() => self
                .motor
                .as_ref()
                .map_or(value, AttachedMotor::encoder_counter),
            a if a == TIM4 + 0x10 && self.captures_index() => {
                let waits = self.motor.as_ref().is_some_and(AttachedMotor::has_index);
                value | u32::from(waits) << 3
            }
            a if a == TIM4 + 0x3c && self.captures_index() => {
                let captured = self.motor.as_mut().and_then(AttachedMotor::take_index);
                if let Some(count) = captured {
                    self.set(TIM4 + 0x3c, count);
                }
                self.get(TIM4 + 0x3c)
            }
            a if a == FDCAN + 0x18 => value & !8 | (value & 0x10) >> 1,
            CAN_STATUS => self.can_status(),
            a if a == FDCAN + 0xc4 => self.queue_status(),
            a if a == GPIO + 0x410 => {
                let levels = self.with_shaft_sensor(u32::from(self.pins().port_b));
                let halls = self.motor.as_ref().and_then(AttachedMotor::hall_levels);
                halls.map_or(levels, |halls| levels & !(7 << 6) | halls << 6)
            }
            a if a == GPIO + 0x810 => u32::from(self.pins().port_c) | self.i2c_levels(),
            _ => value,
        }
    }

    #[allow(clippy::too_many_lines)] // one arm per register
    fn write(&mut self, address: u32, value: u32) {
        let clock = self.clock;
        let value = self.write_of_defect(address, value);
        if !self.forgets_writes {
            self.writes.push(Write {
                clock,
                address,
                value,
            });
        }
        self.changed = true;
        // A timer without clock ignores writes.
        if (TIM1..TIM1 + 0x400).contains(&address) && self.get(RCC + 0x60) & 1 << 11 == 0 {
            return;
        }
        self.clear_serial(address, value);
        if address == BDTR {
            self.race(value);
        }
        let old = self.get(address);
        let value = match address {
            TIM1 if value & !old & 1 != 0 => {
                self.tim1_start = clock;
                let bridge = self.bridge();
                if let Some(motor) = &mut self.motor {
                    motor.start_period(clock, &bridge);
                }
                value
            }
            TIM4 if value & !old & 1 != 0 => {
                let count = self.get(TIM4 + 0x24);
                if let Some(motor) = &mut self.motor {
                    motor.start_encoder(count);
                }
                value
            }
            TIM2 if value & !old & 1 != 0 => {
                self.tim2_start = clock;
                self.advanced = clock;
                value
            }
            a if a == TIM1 + 0x10 || a == TIM2 + 0x10 => old & value,
            // With a lock level, only MOE can be written.
            BDTR if old & 0x300 != 0 => old & !MOE | value & MOE,
            // An event generation bit reads as 0.
            a if a == TIM1 + 0x14 || a == TIM2 + 0x14 => 0,
            a if a == RCC + 0x94 && value & 1 << 23 != 0 => value & 1,
            a if a == RCC + 0x20 => {
                self.clear_clock_flags(value);
                0
            }
            a if a == FLASH_CONTROL + 0x08 => {
                self.flash().unlock(value);
                0
            }
            // Writing 1 clears a flag.
            breaks::ERRORS => old & !value,
            a if a == FLASH_CONTROL + 0x10 => {
                self.flash().status &= !value;
                0
            }
            a if a == FLASH_CONTROL + 0x14 => {
                let before = self.flash().operations;
                self.flash().set_control(value);
                self.check_flash(before);
                0
            }
            IWDG => {
                self.write_watchdog(value);
                value
            }
            a if State::is_i2c(a) => self.write_i2c(a, value),
            a if (DMA1..DMA1 + 0xa8).contains(&a) => self.write_dma(a, value),
            a if ADC.contains(&a) => old & !value,
            a if ADC.iter().any(|adc| a == adc + 0x08) => {
                if value & 1 != 0 {
                    let ready = self.get(address - 8) | 1;
                    self.set(address - 8, ready);
                }
                // Calibration is over at once, and stop bits clear themselves.
                value & !0x8000_0032
            }
            a if a == FDCAN + 0x18 => {
                self.control_can(value);
                value
            }
            a if a == FDCAN + 0x50 => old & !value,
            a if a == FDCAN + 0x94 => {
                self.acknowledge(value);
                value
            }
            a if a == FDCAN + 0xcc => {
                self.request(value);
                0
            }
            a if a == FDCAN + 0xd0 => {
                self.cancel(value);
                0
            }
            a if (GPIO..GPIO + 0x2000).contains(&a) && a & 0x3ff == 0x18 => {
                let output = a - 4;
                let level = self.get(output) & !(value >> 16) | value & 0xffff;
                self.set(output, level);
                0
            }
            _ => value,
        };
        self.set(address, value);
        self.drive_shaft_sensor(address);
    }

    /// Counts a change of the flash memory while the gates are driven: the core stops for 22 ms.
    fn check_flash(&mut self, operations_before: u32) {
        if self.flash().operations != operations_before && self.drives() {
            self.changed_while_live += 1;
        }
    }

    /// A key in the watchdog's register starts or feeds it.
    fn write_watchdog(&mut self, key: u32) {
        let reload = u64::from(self.get(IWDG + 8)) + 1;
        let prescaler = 4_u64 << self.get(IWDG + 4);
        let period = reload * prescaler * CORE_HZ / 32_000;
        match key {
            // The reset value of the reload register is used until it is written.
            0xcccc => self.watchdog = Some(self.clock + 4096 * 4 * CORE_HZ / 32_000),
            0xaaaa if self.watchdog.is_some() => self.watchdog = Some(self.clock + period),
            _ => {}
        }
    }

    /// Period of TIM1 and the time in it at which TRGO2 rises: channel 4 counting down.
    fn trigger(&self) -> Option<(u64, u64)> {
        let running = self.get(TIM1) & 1 != 0;
        let centred = self.get(TIM1) >> 5 & 3 != 0;
        let from_channel_4 = self.get(TIM1 + 4) >> 20 & 15 == 7;
        let reload = u64::from(self.get(TIM1 + 0x2c));
        let compare = u64::from(self.get(TIM1 + 0x40));
        (running && centred && from_channel_4 && reload > compare)
            .then(|| (2 * reload, 2 * reload - compare))
    }

    /// The encoder's timer counts the edges of both inputs.
    fn counts_encoder(&self) -> bool {
        let mode = self.get(TIM4 + 0x08);
        self.get(TIM4) & 1 != 0 && mode & 7 == 3 && mode & 1 << 16 == 0
    }

    /// Channel 3 of the encoder's timer captures the count at rising edges of PB8.
    fn captures_index(&self) -> bool {
        let own_input = self.get(TIM4 + 0x1c) & 3 == 1;
        let rising = self.get(TIM4 + 0x20) >> 8 & 0b1011 == 0b0001;
        let port_b = GPIO + 0x400;
        let alternate = self.get(port_b) >> 16 & 3 == 2 && self.get(port_b + 0x24) & 15 == 2;
        self.counts_encoder() && own_input && rising && alternate
    }

    /// What the bridge does with the motor.
    fn bridge(&self) -> Bridge {
        // Outputs of phases a and b, high and low side.
        let enabled = self.get(TIM1 + 0x20) & 0x55 == 0x55;
        let counting = self.get(TIM1) & 1 != 0;
        Bridge {
            live: self.drives() && enabled && counting,
            compares: [0x34, 0x38, 0x3c].map(|compare| self.get(TIM1 + compare)),
            reload: self.get(TIM1 + 0x2c),
        }
    }

    /// Turns the motor up to the present clock. Returns the clock at which it must be turned again.
    fn turn_motor(&mut self) -> u64 {
        let bridge = self.bridge();
        let clock = self.clock;
        let Some(motor) = &mut self.motor else {
            return u64::MAX;
        };
        while motor.next() <= clock {
            motor.half_period(&bridge);
        }
        motor.next()
    }

    fn convert(&mut self) {
        let dead_clocks = self.get(BDTR) & 0x7f;
        if let (Some(motor), Some(pins)) = (&mut self.motor, &mut self.pins) {
            [pins.phase_a, pins.phase_b, pins.phase_c] =
                motor.current_codes(dead_clocks, pins.zeros);
        }
        for (number, adc) in ADC.into_iter().enumerate() {
            let sequence = self.get(adc + 0x4c);
            let started = self.get(adc + 0x08) & 9 == 9;
            // Trigger 8 is TIM1_TRGO2, on its rising edge.
            if !started || sequence >> 2 & 31 != 8 || sequence >> 7 & 3 != 1 {
                continue;
            }
            let pins = self.pins();
            for rank in 0..=(sequence & 3) {
                let amplifier = |index: u32| self.get(0x4001_0300 + 4 * index) & 1 != 0;
                let code = match (number, sequence >> (9 + 6 * rank) & 31) {
                    (0, 3) if amplifier(0) => pins.phase_a,
                    (1, 3) if amplifier(1) => pins.phase_b,
                    (0, 12) if amplifier(2) => pins.phase_c,
                    (0, 1) => pins.supply,
                    (0, 5) => pins.temperature,
                    _ => 0,
                };
                self.set(adc + 0x80 + 4 * rank, u32::from(code));
            }
            let flags = self.get(adc) | 0x60;
            self.set(adc, flags);
        }
    }

    /// Advances the peripherals to the clock. Returns the clock of the next event.
    fn advance(&mut self) -> u64 {
        let (from, to) = (self.advanced, self.clock);
        self.advanced = to;
        self.changed = false;
        let mut next = self.turn_motor().min(to + CORE_HZ / 1_000);
        if let Some((period, moment)) = self.trigger().filter(|_| self.has_clock()) {
            let start = self.tim1_start;
            let count = |clock: u64| (clock.saturating_sub(start) + period - moment) / period;
            if count(to) > count(from.max(start)) {
                self.convert();
            }
            next = next.min(start + count(to) * period + moment);
        }
        if self.get(TIM2) & 1 != 0 {
            let (before, after) = (self.tim2_ticks(from), self.tim2_ticks(to));
            let mut flags = self.get(TIM2 + 0x10);
            let per_tick = u64::from(self.get(TIM2 + 0x28)) + 1;
            for (bit, compare) in [(0, 0), (1, 0x34), (2, 0x38), (3, 0x3c), (4, 0x40)] {
                let at = if bit == 0 {
                    0
                } else {
                    u64::from(self.get(TIM2 + compare))
                };
                let count = |ticks: u64| (ticks + 0x1_0000 - at) >> 16;
                if count(after) > count(before) {
                    flags |= 1 << bit;
                }
                let tick = (count(after) << 16) + at;
                next = next.min(self.tim2_start + tick * per_tick);
            }
            self.set(TIM2 + 0x10, flags);
        }
        next = next.min(self.advance_can()).min(self.advance_serial());
        next = next.min(self.advance_i2c());
        self.advance_breaks();
        next = next.min(self.next_interrupt());
        if let Some(deadline) = self.watchdog {
            next = next.min(deadline);
        }
        next
    }

    /// Levels of the interrupt lines.
    fn lines(&self) -> impl Iterator<Item = (u16, bool)> {
        let adc = ADC
            .iter()
            .any(|adc| self.get(*adc) & self.get(adc + 4) != 0);
        let timer = self.get(TIM2 + 0x10) & self.get(TIM2 + 0x0c) != 0;
        let can =
            self.get(FDCAN + 0x50) & self.get(FDCAN + 0x54) != 0 && self.get(FDCAN + 0x5c) & 1 != 0;
        let lines = [
            (ADC1_2, adc),
            (TIM2_IRQ, timer),
            (FDCAN1_IT0, can),
            (USART1_IRQ, self.serial_line()),
        ];
        let i2c = self.i2c_lines().into_iter().flat_map(|[event, error]| {
            let [first, second] = self.dma_lines();
            [
                (I2C3_EV, event),
                (I2C3_ER, error),
                (DMA1_CHANNELS[0], first),
                (DMA1_CHANNELS[1], second),
            ]
        });
        lines.into_iter().chain(i2c)
    }
}

/// The peripherals' part of the address space, from `base`.
struct Peripherals {
    base: u32,
    state: Arc<Mutex<State>>,
}

impl fmt::Debug for Peripherals {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "peripherals from {:#x}", self.base)
    }
}

impl MemOps for Peripherals {
    fn read(&self, offset: u64, bytes: &mut [u8], _: MemAttrs) -> MemResult {
        let address = self.base + offset as u32;
        let word = self.state.lock().expect("a state").read(address & !3);
        let start = (address & 3) as usize;
        bytes.copy_from_slice(&word.to_le_bytes()[start..start + bytes.len()]);
        Ok(())
    }

    fn write(&self, offset: u64, bytes: &[u8], _: MemAttrs) -> MemResult {
        let address = self.base + offset as u32;
        let mut state = self.state.lock().expect("a state");
        let mut word = state.get(address & !3).to_le_bytes();
        let start = (address & 3) as usize;
        word[start..start + bytes.len()].copy_from_slice(bytes);
        state.write(address & !3, u32::from_le_bytes(word));
        Ok(())
    }

    fn constraints(&self) -> AccessConstraints {
        AccessConstraints::ANY
    }
}

/// Stores to the flash memory, which program it.
struct Programming(Arc<Mutex<State>>);

impl fmt::Debug for Programming {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "programming")
    }
}

impl MemOps for Programming {
    fn read(&self, _: u64, _: &mut [u8], _: MemAttrs) -> MemResult {
        unreachable!("only stores come here")
    }

    fn write(&self, offset: u64, bytes: &[u8], _: MemAttrs) -> MemResult {
        let word = bytes.try_into().expect("flash memory is written by words");
        let mut state = self.0.lock().expect("a state");
        let before = state.flash().operations;
        state.flash().program(offset, u32::from_le_bytes(word));
        state.check_flash(before);
        Ok(())
    }

    fn constraints(&self) -> AccessConstraints {
        AccessConstraints::ANY
    }
}

/// A chip that executes a flash image.
pub struct Chip {
    part: Part,
    cpu: ArmV7m,
    state: Arc<Mutex<State>>,
    flash: Arc<RamStore>,
    timed_flash: Arc<wait_states::TimedFlash>,
    ram: Arc<RamStore>,
    other: Arc<RamStore>,
    next: u64,
    /// Number of instructions that the core has executed.
    pub instructions: u64,
    watcher: Option<observe::Watcher>,
    defect: Option<Defect>,
    /// Largest number of instructions of one current interrupt so far.
    pub current_interrupt: u32,
    /// Largest time of one current interrupt so far, with its entry, core clocks.
    pub current_interrupt_clocks: u64,
}

impl Chip {
    /// The motor board's chip with these segments in its flash memory, that starts at `start`.
    pub fn new(segments: &[Segment], start: u32) -> Self {
        Self::of(STM32G431, segments, start)
    }

    /// A chip with these segments in its flash memory, that starts at `start`.
    pub fn of(part: Part, segments: &[Segment], start: u32) -> Self {
        let mut image = vec![0xff; part.flash];
        for segment in segments {
            let at = (segment.address - FLASH) as usize;
            image[at..at + segment.bytes.len()].copy_from_slice(&segment.bytes);
        }
        let flash = Arc::new(RamStore::new(part.flash as u64));
        flash.write_at(0, &image).expect("a flash memory");
        let ram = Arc::new(RamStore::new(part.ram));
        ram.write_at(0, &vec![PAINT; part.ram as usize])
            .expect("RAM");
        let other = Arc::new(RamStore::new(0x400));
        let memory = FlashMemory::new(Arc::clone(&flash), part.bank);
        let torn = Arc::clone(&memory.torn);
        let timed_flash = Arc::new(wait_states::TimedFlash::new(Arc::clone(&flash), torn));
        let state = Arc::new(Mutex::new(State {
            pins: Some(Pins {
                zeros: [ZERO; 3],
                // No current: 2.057 V.
                phase_a: 2_553,
                phase_b: 2_553,
                phase_c: 2_553,
                supply: 2866, // 24 V
                temperature: 1309,
                safe_torque_off: true,
                over_current: [false; 3],
                chip_supply: 3.3,
                // Home switch open, limit switches closed, encoder inputs pulled up.
                port_b: 1 << 8 | 3 << 6,
                // Emergency stop closed, dead-man switch held.
                port_c: 0,
            }),
            part,
            flash: Some(memory),
            memories: Some([Arc::clone(&flash), Arc::clone(&ram)]),
            ..State::default()
        }));
        state.lock().expect("a state").reset(false);
        let space = AddressSpace::new("chip", 32);
        {
            let mut map = space.topology();
            let reads = Arc::clone(&timed_flash);
            let flash = Region::io("flash", part.flash as u64, reads);
            map.map_with_perms(flash, FLASH.into(), Perms::RX)
                .expect("flash memory");
            let length = part.flash as u64;
            let programming = Arc::new(Programming(Arc::clone(&state)));
            let programming = Region::io("programming", length, programming);
            let stores = Mapping::new(programming, FLASH.into()).with_perms(Perms::WRITE);
            map.map_with(stores.with_priority(1)).expect("stores");
            map.map(Region::ram("ram", Arc::clone(&ram)), RAM.into())
                .expect("RAM");
            // Calibration values and the debug unit, which the library reads or writes.
            for address in [0x1fff_7400, 0xe004_2000] {
                let region = Region::ram("other", Arc::clone(&other));
                map.map(region, address).expect("memory");
            }
            for (base, length) in [(0x4000_0000, 0x0200_0000), (0x4800_0000, 0x0a00_0000)] {
                let region = Region::io(
                    "peripherals",
                    length,
                    Arc::new(Peripherals {
                        base,
                        state: Arc::clone(&state),
                    }),
                );
                map.map(region, base.into()).expect("peripherals");
            }
        }
        let cpu = ArmV7m::new(
            Config::CORTEX_M4F
                .with_priority_bits(4)
                .with_bit_band(false)
                .with_reset_vtor(start),
        );
        cpu.attach_space(Arc::new(space));
        observe::store_at_entry(&cpu);
        Self {
            part,
            cpu,
            state,
            flash,
            timed_flash,
            ram,
            other,
            next: 0,
            instructions: 0,
            watcher: None,
            defect: None,
            current_interrupt: 0,
            current_interrupt_clocks: 0,
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().expect("a state")
    }

    /// Runs for `microseconds`.
    pub fn run(&mut self, microseconds: u64) {
        self.run_until(self.clock() + microseconds * CORE_HZ / 1_000_000);
    }

    /// Time since the chip was switched on, core clocks.
    pub fn clock(&self) -> u64 {
        self.state().clock
    }

    /// Runs up to this clock.
    pub fn run_until(&mut self, end: u64) {
        let mut clock = self.clock();
        let (mut instructions, mut clocks) = (0, 0);
        let observed = !self.state().forgets_writes;
        while clock < end {
            let mut state = self.state.lock().expect("a state");
            state.clock = clock;
            if state.flash().is_dead() {
                return;
            }
            // An exception loses the state of the IT block that it interrupts in this version of
            // rsemu, so an interrupt waits for the end of the block. The silicon saves the state.
            let due = clock >= self.next || state.changed;
            if due && self.cpu.xpsr() & IT_STATE == 0 {
                self.next = state.advance();
                for (line, level) in state.lines() {
                    self.cpu.set_irq(line, level);
                }
                self.cpu.set_nmi(state.nmi());
                if state.watchdog.is_some_and(|deadline| clock >= deadline) {
                    state.reset(true);
                    state.resets += 1;
                    self.cpu = observe::new_core(&self.cpu);
                }
            }
            let runs = state.has_clock() && !state.is_halted();
            let slowness = state.slowness();
            self.timed_flash.begin(state.get(FLASH_CONTROL), clock);
            drop(state);
            if !runs {
                clock = self.next.min(end).max(clock + 1);
                continue;
            }
            if self.cpu.is_asleep() {
                self.cpu.step();
                if self.cpu.is_asleep() {
                    clock = self.next.min(end).max(clock + 1);
                    continue;
                }
            }
            let taken = self.cpu.step() + self.timed_flash.take_waited();
            clock += slowness * taken;
            self.instructions += 1;
            if self.timed_flash.take_error() {
                self.state().fail_flash();
            }
            self.apply_defect();
            self.observe(clock);
            if observed && self.cpu.current_exception() == Exception(16 + ADC1_2) {
                instructions += 1;
                clocks += taken;
                self.current_interrupt = self.current_interrupt.max(instructions);
                self.current_interrupt_clocks = self.current_interrupt_clocks.max(clocks);
            } else {
                (instructions, clocks) = (0, 0);
            }
            assert!(!self.cpu.is_locked_up(), "at {:#x}", self.cpu.pc());
        }
        self.state().clock = clock;
    }

    /// Value of a register.
    pub fn register(&self, address: u32) -> u32 {
        self.state().read(address)
    }

    /// Keeps no register writes and counts no instructions of the current interrupt from now on.
    /// This is faster.
    pub fn forget_writes(&mut self) {
        self.state().forgets_writes = true;
    }

    /// Connects a motor at rest to phases a and b and to the encoder inputs; `None` if the model's
    /// values are out of their bounds.
    #[must_use]
    pub fn attach_motor(&mut self, model: MotorModel, seed: u64) -> Option<()> {
        let motor = AttachedMotor::new(model, seed)?;
        self.state().motor = Some(motor);
        Some(())
    }

    /// Connects the Hall sensors of the attached motor to the inputs of encoder and home switch.
    pub fn connect_halls(&mut self) {
        if let Some(motor) = &mut self.state().motor {
            motor.connect_halls();
        }
    }

    /// Sets supply, load and switches, and what acts on the sensor modules.
    pub fn set_sensors(&mut self, sensors: &Sensors) {
        if let Some(body) = sensors.body {
            self.acts(|acts| *acts = body);
        }
        let mut state = self.state();
        if let Some(motor) = &mut state.motor {
            motor.set_load(
                sensors.supply_voltage,
                sensors.shaft_torque,
                sensors.encoder_frozen,
            );
        }
        drop(state);
        let switches = sensors.switches;
        self.pins(|pins| {
            pins.supply = supply_code(sensors.supply_voltage);
            // The home switch closes to ground, the limit switches open. The encoder inputs are
            // pulled up.
            pins.port_b = u16::from(!switches.home) << 8
                | u16::from(switches.positive_limit) << 3
                | u16::from(switches.negative_limit) << 4
                | 3 << 6;
        });
    }

    /// Connects the modules with the sensor chips to the I2C bus, and switches them on. They are at
    /// rest on level ground.
    pub fn connect_modules(&mut self) {
        self.state().connect_modules();
    }

    /// Changes what acts on the sensors of the modules, if they are connected.
    pub fn acts(&mut self, change: impl FnOnce(&mut BodyMeasurands)) {
        if let Some(acts) = self.state().acts() {
            change(acts);
        }
    }

    /// Connects a sensor at the output shaft to the pads of the limit switches.
    pub fn connect_shaft_sensor(&mut self, chip: ShaftChip) {
        self.state().connect_shaft_sensor(chip);
    }

    /// Changes this sensor.
    ///
    /// # Panics
    /// No sensor is connected.
    pub fn shaft_sensor<R>(&mut self, change: impl FnOnce(&mut ShaftSensor) -> R) -> R {
        change(self.state().shaft_sensor.as_mut().expect("a sensor"))
    }

    /// Motion of the motor's output shaft; at rest without a motor.
    pub fn shaft(&self) -> Shaft {
        let state = self.state();
        state
            .motor
            .as_ref()
            .map_or_else(Shaft::default, AttachedMotor::shaft)
    }

    /// Gives the chip an identity of its own (RM0440, 47.1).
    pub fn set_serial_number(&mut self, number: u64) {
        self.other
            .write_at(0x190, &number.to_le_bytes())
            .expect("the place of the identity");
    }

    /// Changes bytes of RAM; ignores other addresses.
    pub fn set_ram(&mut self, address: u32, bytes: &[u8]) {
        let offset = u64::from(address.wrapping_sub(RAM));
        let _ = self.ram.write_at(offset, bytes);
    }

    /// All register writes since the start.
    pub fn writes(&self) -> Vec<Write> {
        self.state().writes.clone()
    }

    /// Whether the transistors can be switched on.
    pub fn is_live(&self) -> bool {
        self.state().drives()
    }

    /// Number of changes of the flash memory while the gates were driven.
    pub fn changed_while_live(&self) -> u32 {
        self.state().changed_while_live
    }

    /// Number of resets by the watchdog.
    pub fn resets(&self) -> u32 {
        self.state().resets
    }

    /// Changes what the pins of the chip see.
    pub fn pins(&mut self, change: impl FnOnce(&mut Pins)) {
        let mut state = self.state();
        change(state.pins.as_mut().expect("pins"));
        state.changed = true;
    }

    /// Sends a frame to the chip.
    pub fn send(&mut self, frame: Frame) {
        let mut state = self.state();
        state.received.push_back(frame);
        state.changed = true;
    }

    /// Sends bytes to the serial line without a pause, at this bit rate.
    pub fn send_serial(&mut self, bytes: &[u8], baud: u64) {
        self.state().send_serial(bytes, baud);
    }

    /// Removes and returns the frames that the chip has sent, with their clocks.
    pub fn take_sent(&mut self) -> Vec<(u64, Frame)> {
        std::mem::take(&mut self.state().sent)
    }

    /// Continues at another address, as after a wild jump.
    pub fn jump(&mut self, address: u32) {
        while self.cpu.is_asleep() {
            self.run(1);
        }
        self.cpu.set_pc(address);
    }

    /// Continues in a function with this first argument.
    pub fn call(&mut self, function: u32, argument: u32) {
        self.jump(function);
        self.cpu.set_reg(0, argument);
    }

    /// Writes an endless loop into unused RAM and makes the thread run it. Interrupts still run.
    pub fn hang(&mut self) {
        self.hang_in(0);
    }

    /// The same in the exception with this number; 0 is the thread. More urgent interrupts still
    /// run.
    pub fn hang_in(&mut self, exception: u16) {
        while self.cpu.current_exception() != Exception(exception) {
            self.run(1);
        }
        let unused = self.part.ram / 4 * 3;
        // `b .` twice.
        self.ram
            .write_at(unused, &[0xfe, 0xe7, 0xfe, 0xe7])
            .expect("RAM");
        self.cpu.set_pc(RAM + unused as u32);
    }

    /// Bytes of RAM that were ever written.
    pub fn used_ram(&self) -> usize {
        let mut bytes = vec![0; self.part.ram as usize];
        self.ram.read_at(0, &mut bytes).expect("RAM");
        // The longest run of untouched bytes is between the static variables and the stack.
        let runs = bytes.split(|byte| *byte != PAINT);
        bytes.len() - runs.map(<[u8]>::len).max().unwrap_or(0)
    }

    /// Priority of an interrupt; 0 is the most urgent.
    pub fn priority(&self, interrupt: u16) -> i32 {
        self.cpu
            .with_sys(|system| system.priority_of(Exception(16 + interrupt)))
            >> 4
    }

    /// Uses the flash memory.
    pub fn flash<R>(&mut self, use_it: impl FnOnce(&mut FlashMemory) -> R) -> R {
        use_it(self.state().flash())
    }

    /// Double words of the flash memory with an error of two bits, counted from its start.
    pub fn torn(&self) -> BTreeSet<u64> {
        self.state().flash().torn.lock().expect("words").clone()
    }

    /// Gives these double words such an error.
    pub fn tear(&mut self, words: &BTreeSet<u64>) {
        self.flash(|flash| flash.torn.lock().expect("words").extend(words));
    }

    /// Changes bytes of the flash memory.
    pub fn patch(&mut self, address: u32, bytes: &[u8]) {
        self.flash
            .write_at((address - FLASH).into(), bytes)
            .expect("flash memory");
    }
}
