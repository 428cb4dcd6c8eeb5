//! A model of the STM32G431 around rsemu's Cortex-M4F: as much of it as the images of the motor
//! board use.
//!
//! Registers without a behaviour below keep what is written. Reset values are by hand: those of
//! `RCC`, `PWR` and `FLASH` from the reference manual RM0440 (7.4, 6.4, 5.7), those of `FDCAN` from
//! its section 44.4. Not modelled: wait states, bus contention, CAN errors and arbitration, DMA and
//! everything analogue.

use crate::flash_memory::{FlashMemory, LOCK};
use rsemu::core::space::{
    AccessConstraints, AddressSpace, Mapping, MemAttrs, MemOps, MemResult, Perms, RamStore, Region,
};
use rsemu::cpu::arm::v7m::sys::Exception;
use rsemu::cpu::arm::v7m::{ArmV7m, Config};
use std::collections::{HashMap, VecDeque};
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard};
use tautrack::can::Frame;
use tautrack_host_tests::programs::flash::Segment;

/// Core clock after the start, Hz. The model's time counts these clocks.
pub const CORE_HZ: u64 = 170_000_000;
pub const FLASH: u32 = 0x0800_0000;
const FLASH_LENGTH: usize = 128 * 1024;
const RAM_LENGTH: u64 = 32 * 1024;
/// Contents of RAM that nothing was written to.
const PAINT: u8 = 0x5a;

pub const RCC: u32 = 0x4002_1000;
pub const PWR: u32 = 0x4000_7000;
pub const FLASH_CONTROL: u32 = 0x4002_2000;
pub const TIM1: u32 = 0x4001_2c00;
pub const TIM2: u32 = 0x4000_0000;
pub const IWDG: u32 = 0x4000_3000;
pub const FDCAN: u32 = 0x4000_6400;
const MESSAGES: u32 = 0x4000_a400;
const ADC: [u32; 2] = [0x5000_0000, 0x5000_0100];
pub const GPIO: u32 = 0x4800_0000;

pub const BDTR: u32 = TIM1 + 0x44;
/// Main output enable in [`BDTR`].
pub const MOE: u32 = 1 << 15;
const BREAK_FLAG: u32 = 1 << 7;

/// Bits of the core's program status register that are 0 outside IT blocks.
const IT_BLOCK: u32 = 0x0600_fc00;

/// Interrupt numbers.
pub const ADC1_2: u16 = 18;
pub const FDCAN1_IT0: u16 = 21;
pub const TIM2_IRQ: u16 = 28;
pub const CONTROL: u16 = 39;

/// Register write of the image.
#[derive(Clone, Copy, Debug)]
pub struct Write {
    pub clock: u64,
    pub address: u32,
    pub value: u32,
}

/// Voltages and levels at the chip's pins.
#[derive(Clone, Copy, Debug)]
pub struct Pins {
    /// Codes of the converters: phase a, phase b, supply, temperature.
    pub phase_a: u16,
    pub phase_b: u16,
    pub supply: u16,
    pub temperature: u16,
    /// Level of the input "safe torque off".
    pub safe_torque_off: bool,
    /// Level of comparator 1: over-current.
    pub over_current: bool,
    /// Levels of port B.
    pub port_b: u16,
}

#[derive(Default)]
struct State {
    registers: HashMap<u32, u32>,
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
    patch: Option<Patch>,
    flash: Option<FlashMemory>,
}

/// Change of all writes to one register: it makes the image one that has a defect.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    pub address: u32,
    /// Bits of the register that get the bits of `value`.
    pub mask: u32,
    pub value: u32,
}

impl State {
    fn reset(&mut self, watchdog: bool) {
        self.registers = [
            (RCC, 0x0000_0500),
            // The cause of the reset: the watchdog, or power-up (brown-out and pin).
            (RCC + 0x94, if watchdog { 0x2400_0000 } else { 0x0c00_0000 }),
            (PWR, 0x0000_0200),
            (PWR + 0x80, 0x0000_0100),
            (FLASH_CONTROL, 0x0004_0600),
            (FDCAN, 0x3214_1218),
            (FDCAN + 0x04, 0x8765_4321),
            (FDCAN + 0x18, 0x0000_0001),
            (FDCAN + 0x1c, 0x0600_0a03),
            (FDCAN + 0xc4, 0x0000_0003),
            (GPIO, 0xabff_ffff),
            (GPIO + 0x400, 0xffff_febf),
        ]
        .into();
        self.watchdog = None;
        if let Some(flash) = &mut self.flash {
            flash.control = LOCK;
        }
        self.received.clear();
        self.changed = true;
    }

    /// The flash memory.
    pub fn flash(&mut self) -> &mut FlashMemory {
        self.flash.as_mut().expect("the chip has flash memory")
    }

    fn get(&self, address: u32) -> u32 {
        self.registers.get(&address).copied().unwrap_or(0)
    }

    fn set(&mut self, address: u32, value: u32) {
        self.registers.insert(address, value);
    }

    fn pins(&self) -> Pins {
        self.pins.expect("the chip has pins")
    }

    fn tim2_ticks(&self, clock: u64) -> u64 {
        (clock - self.tim2_start) / (u64::from(self.get(TIM2 + 0x28)) + 1)
    }

    fn read(&mut self, address: u32) -> u32 {
        let value = self.get(address);
        match address {
            // Oscillators and the PLL are ready at once.
            RCC => value | (value & 0x0101_0100) << 1 | (value & 1 << 8) << 2,
            a if a == RCC + 0x08 => value & !0xc | (value & 3) << 2,
            a if a == RCC + 0x94 || a == RCC + 0x98 => value | (value & 1) << 1,
            a if a == FLASH_CONTROL + 0x10 => self.flash().status,
            a if a == FLASH_CONTROL + 0x14 => self.flash().control,
            a if a == IWDG + 0x0c => 0,
            a if a == TIM2 + 0x24 && self.get(TIM2) & 1 != 0 => {
                (self.tim2_ticks(self.clock) & 0xffff) as u32
            }
            a if a == FDCAN + 0x18 => value & !8 | (value & 0x10) >> 1,
            a if a == GPIO + 0x410 => u32::from(self.pins().port_b),
            _ => value,
        }
    }

    fn write(&mut self, address: u32, value: u32) {
        let clock = self.clock;
        let value = match self.patch {
            Some(patch) if patch.address == address => value & !patch.mask | patch.value,
            _ => value,
        };
        self.writes.push(Write {
            clock,
            address,
            value,
        });
        self.changed = true;
        // A timer without clock ignores writes.
        if (TIM1..TIM1 + 0x400).contains(&address) && self.get(RCC + 0x60) & 1 << 11 == 0 {
            return;
        }
        let old = self.get(address);
        let value = match address {
            TIM1 if value & !old & 1 != 0 => {
                self.tim1_start = clock;
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
            a if a == FLASH_CONTROL + 0x08 => {
                self.flash().unlock(value);
                0
            }
            a if a == FLASH_CONTROL + 0x10 => {
                self.flash().status &= !value;
                0
            }
            a if a == FLASH_CONTROL + 0x14 => {
                self.flash().set_control(value);
                0
            }
            IWDG => {
                let reload = u64::from(self.get(IWDG + 8)) + 1;
                let prescaler = 4_u64 << self.get(IWDG + 4);
                let period = reload * prescaler * CORE_HZ / 32_000;
                match value {
                    // The reset value of the reload register is used until it is written.
                    0xcccc => self.watchdog = Some(clock + 4096 * 4 * CORE_HZ / 32_000),
                    0xaaaa if self.watchdog.is_some() => self.watchdog = Some(clock + period),
                    _ => {}
                }
                value
            }
            a if ADC.contains(&a) => old & !value,
            a if ADC.iter().any(|adc| a == adc + 0x08) => {
                if value & 1 != 0 {
                    let ready = self.get(address - 8) | 1;
                    self.set(address - 8, ready);
                }
                // Calibration is over at once, and stop bits clear themselves.
                value & !0x8000_0032
            }
            a if a == FDCAN + 0x50 => old & !value,
            a if a == FDCAN + 0x94 => {
                self.acknowledge(value);
                value
            }
            a if a == FDCAN + 0xcc => {
                self.transmit(value);
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
    }

    fn transmit(&mut self, requests: u32) {
        for buffer in (0..3).filter(|buffer| requests & 1 << buffer != 0) {
            let element = MESSAGES + 0x278 + 72 * buffer;
            let length = (self.get(element + 4) >> 16 & 15) as usize;
            let data: Vec<u8> = (0..2)
                .flat_map(|word| self.get(element + 8 + 4 * word).to_le_bytes())
                .take(length)
                .collect();
            let id = (self.get(element) >> 18 & 0x7ff) as u16;
            let frame = Frame::new(id, &data).expect("a classic frame");
            self.sent.push((self.clock, frame));
            let done = self.get(FDCAN + 0xd4) | 1 << buffer;
            self.set(FDCAN + 0xd4, done);
            let flags = self.get(FDCAN + 0x50) | 1 << 7;
            self.set(FDCAN + 0x50, flags);
        }
    }

    /// Puts the oldest received frame into an empty FIFO 0.
    fn receive(&mut self) {
        let status = self.get(FDCAN + 0x90);
        if status & 15 != 0 || self.get(FDCAN + 0x18) & 1 != 0 {
            return;
        }
        let Some(frame) = self.received.pop_front() else {
            return;
        };
        let index = status >> 8 & 3;
        let element = MESSAGES + 0xb0 + 72 * index;
        let mut data = [0; 8];
        data[..frame.data().len()].copy_from_slice(frame.data());
        self.set(element, u32::from(frame.id()) << 18);
        self.set(element + 4, (frame.data().len() as u32) << 16);
        for word in 0..2 {
            let bytes = data[4 * word..4 * word + 4].try_into().expect("a word");
            self.set(element + 8 + 4 * word as u32, u32::from_le_bytes(bytes));
        }
        self.set(FDCAN + 0x90, status & !15 | 1);
        let flags = self.get(FDCAN + 0x50) | 1;
        self.set(FDCAN + 0x50, flags);
    }

    fn acknowledge(&mut self, index: u32) {
        self.set(FDCAN + 0x90, ((index + 1) % 3) << 8);
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

    fn convert(&mut self) {
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
        let mut next = to + CORE_HZ / 1_000;
        if let Some((period, moment)) = self.trigger() {
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
        self.receive();
        let bdtr = self.get(BDTR);
        let af1 = self.get(TIM1 + 0x60);
        let pin = af1 & 1 != 0
            && u32::from(self.pins().safe_torque_off) ^ (af1 >> 9 & 1) == bdtr >> 13 & 1;
        let comparator = af1 & 2 != 0 && self.pins().over_current;
        if bdtr & 1 << 12 != 0 && (pin || comparator) {
            self.set(BDTR, bdtr & !MOE);
            let flags = self.get(TIM1 + 0x10) | BREAK_FLAG;
            self.set(TIM1 + 0x10, flags);
        }
        if let Some(deadline) = self.watchdog {
            next = next.min(deadline);
        }
        next
    }

    /// Levels of the interrupt lines.
    fn lines(&self) -> [(u16, bool); 3] {
        let adc = ADC
            .iter()
            .any(|adc| self.get(*adc) & self.get(adc + 4) != 0);
        let timer = self.get(TIM2 + 0x10) & self.get(TIM2 + 0x0c) != 0;
        let can =
            self.get(FDCAN + 0x50) & self.get(FDCAN + 0x54) != 0 && self.get(FDCAN + 0x5c) & 1 != 0;
        [(ADC1_2, adc), (TIM2_IRQ, timer), (FDCAN1_IT0, can)]
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
        state.flash().program(offset, u32::from_le_bytes(word));
        Ok(())
    }

    fn constraints(&self) -> AccessConstraints {
        AccessConstraints::ANY
    }
}

/// A chip that executes a flash image.
pub struct Chip {
    cpu: ArmV7m,
    state: Arc<Mutex<State>>,
    flash: Arc<RamStore>,
    ram: Arc<RamStore>,
    next: u64,
    /// Largest number of instructions of one current interrupt so far.
    pub current_interrupt: u32,
}

impl Chip {
    /// A chip with these segments in its flash memory, that starts at `start`.
    pub fn new(segments: &[Segment], start: u32) -> Self {
        let mut image = vec![0xff; FLASH_LENGTH];
        for segment in segments {
            let at = (segment.address - FLASH) as usize;
            image[at..at + segment.bytes.len()].copy_from_slice(&segment.bytes);
        }
        let flash = Arc::new(RamStore::new(FLASH_LENGTH as u64));
        flash.write_at(0, &image).expect("a flash memory");
        let ram = Arc::new(RamStore::new(RAM_LENGTH));
        ram.write_at(0, &vec![PAINT; RAM_LENGTH as usize])
            .expect("RAM");
        let other = Arc::new(RamStore::new(0x400));
        let state = Arc::new(Mutex::new(State {
            pins: Some(Pins {
                phase_a: 2048,
                phase_b: 2048,
                supply: 2866, // 24 V
                temperature: 1309,
                safe_torque_off: true,
                over_current: false,
                // Home switch open, limit switches closed, encoder inputs pulled up.
                port_b: 1 << 8 | 3 << 6,
            }),
            flash: Some(FlashMemory::new(Arc::clone(&flash))),
            ..State::default()
        }));
        state.lock().expect("a state").reset(false);
        let space = AddressSpace::new("chip", 32);
        {
            let mut map = space.topology();
            let flash = Region::ram("flash", Arc::clone(&flash));
            map.map_with_perms(flash, FLASH.into(), Perms::RX)
                .expect("flash memory");
            let length = FLASH_LENGTH as u64;
            let programming = Arc::new(Programming(Arc::clone(&state)));
            let programming = Region::io("programming", length, programming);
            let stores = Mapping::new(programming, FLASH.into()).with_perms(Perms::WRITE);
            map.map_with(stores.with_priority(1)).expect("stores");
            map.map(Region::ram("ram", Arc::clone(&ram)), 0x2000_0000)
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
        Self {
            cpu,
            state,
            flash,
            ram,
            next: 0,
            current_interrupt: 0,
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().expect("a state")
    }

    /// Runs for `microseconds`.
    pub fn run(&mut self, microseconds: u64) {
        let mut clock = self.state().clock;
        let end = clock + microseconds * CORE_HZ / 1_000_000;
        let mut instructions = 0;
        while clock < end {
            let mut state = self.state.lock().expect("a state");
            state.clock = clock;
            if state.flash().is_dead() {
                return;
            }
            // The core's model forgets the rest of an IT block if an interrupt comes inside it, and
            // then executes instructions that it must skip. So interrupts wait until its end.
            let due = clock >= self.next || state.changed;
            if due && self.cpu.xpsr() & IT_BLOCK == 0 {
                self.next = state.advance();
                for (line, level) in state.lines() {
                    self.cpu.set_irq(line, level);
                }
                if state.watchdog.is_some_and(|deadline| clock >= deadline) {
                    state.reset(true);
                    state.resets += 1;
                    self.cpu.request_reset();
                }
            }
            drop(state);
            if self.cpu.is_asleep() {
                self.cpu.step();
                if self.cpu.is_asleep() {
                    clock = self.next.min(end).max(clock + 1);
                    continue;
                }
            }
            clock += self.cpu.step();
            if self.cpu.current_exception() == Exception(16 + ADC1_2) {
                instructions += 1;
                self.current_interrupt = self.current_interrupt.max(instructions);
            } else {
                instructions = 0;
            }
            assert!(!self.cpu.is_locked_up(), "at {:#x}", self.cpu.pc());
        }
        self.state().clock = clock;
    }

    /// Makes the image one that writes other values to a register.
    pub fn set_defect(&mut self, patch: Option<Patch>) {
        self.state().patch = patch;
    }

    /// Value of a register.
    pub fn register(&self, address: u32) -> u32 {
        self.state().read(address)
    }

    /// All register writes since the start.
    pub fn writes(&self) -> Vec<Write> {
        self.state().writes.clone()
    }

    /// Whether the transistors can be switched on.
    pub fn is_live(&self) -> bool {
        self.register(BDTR) & MOE != 0
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

    /// Writes an endless loop into unused RAM and makes the thread run it. Interrupts still run.
    pub fn hang(&mut self) {
        while self.cpu.current_exception() != Exception::THREAD {
            self.run(1);
        }
        // `b .` twice.
        self.ram
            .write_at(0x6000, &[0xfe, 0xe7, 0xfe, 0xe7])
            .expect("RAM");
        self.cpu.set_pc(0x2000_6000);
    }

    /// Bytes of RAM that were ever written.
    pub fn used_ram(&self) -> usize {
        let mut bytes = vec![0; RAM_LENGTH as usize];
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

    /// Bytes of the flash memory from `address` on.
    pub fn memory(&self, address: u32, length: usize) -> Vec<u8> {
        let mut bytes = vec![0; length];
        let offset = FlashMemory::offset(address);
        self.flash
            .read_at(offset, &mut bytes)
            .expect("flash memory");
        bytes
    }

    /// Changes bytes of the flash memory.
    pub fn patch(&mut self, address: u32, bytes: &[u8]) {
        self.flash
            .write_at((address - FLASH).into(), bytes)
            .expect("flash memory");
    }
}
