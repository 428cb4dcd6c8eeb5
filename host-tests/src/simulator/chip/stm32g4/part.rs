//! The chips that the model knows, and what differs between them.

use super::reset_values::{ALL, G474};

/// Chip of the family.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Bytes of the flash memory.
    pub(super) flash: usize,
    /// Bytes of a bank of the flash memory.
    pub(super) bank: u64,
    /// Bytes of RAM.
    pub(super) ram: u64,
    /// Values of the registers after a reset: those of every chip, then those of this one.
    reset_values: [&'static [(&'static str, u32, u32)]; 2],
}

/// STM32G431CB, of the motor board. It has one bank.
pub const STM32G431: Part = Part {
    flash: 128 * 1024,
    bank: 128 * 1024,
    ram: 32 * 1024,
    reset_values: [&ALL, &[]],
};

/// STM32G474RE, of the guard's board, with two banks as it is delivered. The part of its RAM that
/// is also at another address is only here.
pub const STM32G474: Part = Part {
    flash: 512 * 1024,
    bank: 256 * 1024,
    ram: 128 * 1024,
    reset_values: [&ALL, &G474],
};

impl Default for Part {
    fn default() -> Self {
        STM32G431
    }
}

impl Part {
    /// Name, address and value of each register that is not 0 after a reset.
    pub fn reset_values(&self) -> impl Iterator<Item = (&'static str, u32, u32)> {
        self.reset_values.into_iter().flatten().copied()
    }
}
