//! What opens the bridge without software: the break inputs of TIM1, and events of the chip itself
//! (RM0440: 7.2.9 clock security, 10.2.8 `SYSCFG_CFGR2`, 29.3.16 breaks).
//!
//! A break input with a filter needs the timer's clock. Without clock security, a crystal that
//! fails stops this clock and the core.

use super::{BDTR, Chip, FLASH_CONTROL, MOE, PWR, RCC, State, TIM1};

/// Clock security on, in the clock control register.
const SECURITY: u32 = 1 << 19;
/// A failure of the crystal, in the interrupt flag register and in the one that clears it.
const FAILURE: u32 = 1 << 8;
/// The register that connects events of the chip with the break.
pub const SYSCFG_CFGR2: u32 = 0x4001_001c;
/// Register of the errors of the flash memory, and the flag of one of two bits.
pub(super) const ERRORS: u32 = FLASH_CONTROL + 0x18;
const TWO_BITS: u32 = 1 << 31;
/// Flags of the breaks in the timer's status register: inputs 1 and 2, and the chip.
const FLAGS: [u32; 3] = [1 << 7, 1 << 8, 1 << 13];
/// Thresholds of the supply voltage detector, V (data sheet DS12589, PVD0 to PVD6).
const LEVELS: [f32; 7] = [2.0, 2.2, 2.36, 2.52, 2.64, 2.81, 2.91];
/// Comparators of phases a, b and c, counted from 0.
const COMPARATORS: [u32; 3] = [0, 1, 3];
/// Control register of the first of them.
const COMPARATOR_CONTROL: u32 = 0x4001_0200;
/// Data of the converter DAC3 for the comparators of phases a, b and c, and its control register.
const THRESHOLDS: [u32; 3] = [0x5000_1008, 0x5000_1014, 0x5000_1014];
const DAC_CONTROL: u32 = 0x5000_1000;
/// Gain of the op-amps, whose inputs are those of the comparators.
const GAIN: u32 = 16;
/// Core clocks from an error of the flash memory to the interrupt. A guess.
const LATE: u64 = 40;

/// An event of the chip that can break the timer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Event {
    /// The core has locked up.
    LockUp,
    /// An error of two bits in the flash memory.
    FlashError,
}

/// The crystal, and events that have just come.
#[derive(Default)]
pub(super) struct Events {
    crystal_failed: bool,
    /// A debug probe has halted the core; TIM1 is frozen with it.
    halted: Option<bool>,
    /// The core has locked up, until a reset.
    locked_up: bool,
    /// Clock at which the interrupt of an error of the flash memory comes.
    interrupt: u64,
    /// Number of errors of the flash memory so far.
    errors: u32,
    /// A break comes just before the next write that sets MOE, and is over at once.
    races: bool,
    new: Vec<Event>,
}

impl State {
    /// Whether the timer of the bridge drives the gates. One that is frozen does not.
    pub(super) fn drives(&self) -> bool {
        self.get(BDTR) & MOE != 0 && self.events.halted != Some(true)
    }

    /// Write of the break register: a break may come just before it.
    pub(super) fn race(&mut self, value: u32) {
        if value & MOE != 0 && std::mem::take(&mut self.events.races) {
            let flags = self.get(TIM1 + 0x10) | FLAGS[0];
            self.set(TIM1 + 0x10, flags);
        }
    }

    /// Whether the core executes nothing: a debug probe has halted it, or it has locked up.
    pub(super) fn is_halted(&self) -> bool {
        self.events.halted.is_some() || self.events.locked_up
    }

    /// Ends what a reset ends.
    pub(super) fn reset_events(&mut self) {
        self.events.locked_up = false;
    }

    /// Whether core and timers have a clock.
    pub(super) fn has_clock(&self) -> bool {
        // The system clock is the crystal's, directly or through the PLL.
        !self.events.crystal_failed || self.get(RCC + 0x08) & 2 == 0
    }

    /// Core clocks of 170 MHz that a clock of the core takes.
    pub(super) fn slowness(&self) -> u64 {
        if self.events.crystal_failed { 10 } else { 1 }
    }

    /// Ready bits of the crystal and the PLL that it drives, which the failed one does not have.
    pub(super) fn ready_mask(&self) -> u32 {
        if self.events.crystal_failed {
            !(1 << 17 | 1 << 25)
        } else {
            u32::MAX
        }
    }

    /// Level of the line of the interrupt that nothing masks.
    pub(super) fn nmi(&self) -> bool {
        let error = self.get(ERRORS) & TWO_BITS != 0 && self.clock >= self.events.interrupt;
        self.get(RCC + 0x1c) & FAILURE != 0 || error
    }

    /// Takes an error of two bits in the flash memory.
    pub(super) fn fail_flash(&mut self) {
        self.events.errors += 1;
        let errors = self.get(ERRORS);
        if errors & TWO_BITS == 0 {
            self.events.interrupt = self.clock + LATE;
        }
        self.set(ERRORS, errors | TWO_BITS);
        self.changed = true;
    }

    /// Clock of the next interrupt of such an error.
    pub(super) fn next_interrupt(&self) -> u64 {
        let waits = self.get(ERRORS) & TWO_BITS != 0 && self.clock < self.events.interrupt;
        if waits {
            self.events.interrupt
        } else {
            u64::MAX
        }
    }

    /// Write of the register that clears flags of the clocks.
    pub(super) fn clear_clock_flags(&mut self, value: u32) {
        let flags = self.get(RCC + 0x1c) & !value;
        self.set(RCC + 0x1c, flags);
    }

    fn fail_crystal(&mut self) {
        self.events.crystal_failed = true;
        self.changed = true;
        if self.get(RCC) & SECURITY != 0 {
            let flags = self.get(RCC + 0x1c) | FAILURE;
            self.set(RCC + 0x1c, flags);
            // The core goes on with the internal oscillator.
            let clocks = self.get(RCC + 0x08) & !3 | 1;
            self.set(RCC + 0x08, clocks);
        }
    }

    /// The supply of the chip is below the level of the detector.
    fn supply_is_low(&self) -> bool {
        let control = self.get(PWR + 4);
        let level = LEVELS.get((control >> 1 & 7) as usize);
        control & 1 != 0 && level.is_some_and(|level| self.pins().chip_supply < *level)
    }

    /// Levels of the comparators of phases a, b and c. They compare the newest samples: blanking is
    /// not modelled.
    fn comparators(&self) -> [bool; 3] {
        let pins = self.pins();
        let codes = [pins.phase_a, pins.phase_b, pins.phase_c];
        std::array::from_fn(|phase| {
            let control = COMPARATOR_CONTROL + 4 * COMPARATORS[phase];
            let channel = if phase == 0 { 1 } else { 1 << 16 };
            let on = self.get(control) & 1 != 0 && self.get(DAC_CONTROL) & channel != 0;
            let threshold = GAIN * (self.get(THRESHOLDS[phase]) & 0xfff);
            pins.over_current[phase] || on && u32::from(codes[phase]) > threshold
        })
    }

    /// Whether one of the sources in an alternate function register is active: the pin, or a
    /// comparator.
    fn source(&self, selected: u32, pin: Option<bool>) -> bool {
        let pin = pin.is_some_and(|level| selected & 1 != 0 && level ^ (selected >> 9 & 1 != 0));
        let comparators = COMPARATORS.iter().zip(self.comparators());
        let comparator = |(number, level): (&u32, bool)| {
            level && selected >> (1 + number) & 1 != 0 && selected >> (10 + number) & 1 == 0
        };
        pin || comparators.into_iter().any(comparator)
    }

    /// Opens the bridge if a break is active.
    pub(super) fn advance_breaks(&mut self) {
        let bdtr = self.get(BDTR);
        let clocked = self.has_clock();
        let input = |enabled: u32, polarity: u32, filter: u32, active: bool| {
            let filtered = bdtr >> filter & 15 != 0;
            bdtr >> enabled & 1 != 0
                && active == (bdtr >> polarity & 1 != 0)
                && (clocked || !filtered)
        };
        let connected = self.get(SYSCFG_CFGR2);
        let mut chip =
            self.get(RCC + 0x1c) & FAILURE != 0 || connected & 4 != 0 && self.supply_is_low();
        for event in std::mem::take(&mut self.events.new) {
            match event {
                Event::LockUp => self.events.locked_up = true,
                Event::FlashError => self.fail_flash(),
            }
        }
        chip |= connected & 1 != 0 && self.events.locked_up;
        chip |= connected & 8 != 0 && self.get(ERRORS) & TWO_BITS != 0;
        let pin = Some(self.pins().safe_torque_off);
        let active = [
            input(12, 13, 16, self.source(self.get(TIM1 + 0x60), pin)),
            input(24, 25, 20, self.source(self.get(TIM1 + 0x64), None)),
            bdtr >> 12 & 1 != 0 && chip,
        ];
        for (flag, active) in FLAGS.into_iter().zip(active) {
            if active {
                let bdtr = self.get(BDTR);
                self.set(BDTR, bdtr & !MOE);
                let flags = self.get(TIM1 + 0x10) | flag;
                self.set(TIM1 + 0x10, flags);
            }
        }
    }
}

impl Chip {
    /// Halts the core for good, as a debug probe does that has found a fault of the core.
    pub fn halt(&mut self) {
        let mut frozen = [0; 4];
        self.other
            .read_at(0x10, &mut frozen)
            .expect("the debug unit");
        let frozen = u32::from_le_bytes(frozen) >> 11 & 1 != 0;
        self.state().events.halted = Some(frozen);
    }

    /// Lets a short break come just before the next write that sets MOE: after the program has
    /// looked whether there is one.
    pub fn race(&mut self) {
        self.state().events.races = true;
    }

    /// Stops the crystal for good.
    pub fn fail_crystal(&mut self) {
        self.state().fail_crystal();
    }

    /// Makes the crystal work again.
    pub fn mend_crystal(&mut self) {
        self.state().events.crystal_failed = false;
    }

    /// Switches the watch of the crystal off.
    pub fn stop_clock_security(&mut self) {
        let mut state = self.state();
        let control = state.get(RCC) & !SECURITY;
        state.set(RCC, control);
    }

    /// Number of errors of the flash memory so far.
    pub fn flash_errors(&self) -> u32 {
        self.state().events.errors
    }

    /// Lets an event of the chip come.
    pub fn event(&mut self, event: Event) {
        let mut state = self.state();
        state.events.new.push(event);
        state.changed = true;
    }
}
