//! Registers of the chip's peripherals, as memory.

use std::collections::HashMap;

/// Parts of the address space that the images use all the time: first address and length.
const USED: [(u32, u32); 3] = [
    (0x4000_0000, 0x3_0000),
    (0x4800_0000, 0x2000),
    (0x5000_0000, 0x2000),
];

/// A word for every register, 0 unless written.
#[derive(Default)]
pub(super) struct Registers {
    used: Vec<u32>,
    others: HashMap<u32, u32>,
}

impl Registers {
    /// Registers with these values.
    pub fn new(values: impl IntoIterator<Item = (u32, u32)>) -> Self {
        let length: u32 = USED.iter().map(|(_, length)| length).sum();
        let mut registers = Self {
            used: vec![0; length as usize / 4],
            others: HashMap::new(),
        };
        for (address, value) in values {
            registers.set(address, value);
        }
        registers
    }

    /// The word at this address.
    #[inline]
    pub fn get(&self, address: u32) -> u32 {
        match place(address) {
            Some(place) => self.used[place],
            None => self.others.get(&address).copied().unwrap_or(0),
        }
    }

    /// Changes the word at this address.
    #[inline]
    pub fn set(&mut self, address: u32, value: u32) {
        match place(address) {
            Some(place) => self.used[place] = value,
            None => {
                self.others.insert(address, value);
            }
        }
    }
}

/// Index of the word at an address among the used ones.
#[inline]
fn place(address: u32) -> Option<usize> {
    let mut before = 0;
    for (first, length) in USED {
        let offset = address.wrapping_sub(first);
        if offset < length {
            return Some(((before + offset) / 4) as usize);
        }
        before += length;
    }
    None
}
