//! Defects of the executed image, by which the tests of the images are tested.

use super::{Chip, IWDG, State};
use rsemu::cpu::arm::v7m::sys::Exception;

/// First address of the core's own registers, which the bus does not see.
const CORE: u32 = 0xe000_0000;
/// Key that feeds the watchdog.
const FEED: u32 = 0xaaaa;

/// What the image does wrong.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Defect {
    /// Every write to a register changes some of its bits.
    Register {
        /// Address of the register.
        address: u32,
        /// Bits of the register that get the bits of `value`.
        mask: u32,
        /// Their new values.
        value: u32,
    },
    /// What writes to the register at this address feeds the watchdog, too.
    FedWith(u32),
    /// The handler of this interrupt masks all others while it runs.
    MaskedIn(u16),
}

impl State {
    /// The word that an image with the defect writes.
    pub(super) fn write_of_defect(&mut self, register: u32, word: u32) -> u32 {
        match self.defect {
            Some(Defect::Register {
                address,
                mask,
                value,
            }) if address == register => word & !mask | value,
            Some(Defect::FedWith(address)) if address == register => {
                self.write(IWDG, FEED);
                word
            }
            _ => word,
        }
    }
}

impl Chip {
    /// Gives the image a defect.
    pub fn set_defect(&mut self, defect: Option<Defect>) {
        self.defect = defect;
        self.state().defect = defect;
    }

    /// Applies a defect in a register of the core after an instruction.
    pub(super) fn apply_defect(&self) {
        match self.defect {
            Some(Defect::Register {
                address,
                mask,
                value,
            }) if address >= CORE => self.cpu.with_sys(|system| {
                let word = system.read_word(address, true).unwrap_or(0);
                system.write_word(address, word & !mask | value);
            }),
            Some(Defect::MaskedIn(interrupt))
                if self.cpu.current_exception() == Exception(16 + interrupt) =>
            {
                // The return from the handler clears FAULTMASK.
                let mut registers = self.cpu.regs();
                registers.faultmask = true;
                self.cpu.set_regs(registers);
            }
            _ => {}
        }
    }
}
