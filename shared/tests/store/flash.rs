//! Flash in memory like that of an STM32G4: pages of 2 KiB, words of 8 bytes. It can lose its power
//! in any operation, and then tears this operation.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

/// Reproducible random numbers (splitmix64).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// A number below `limit`.
    pub fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ (mixed >> 31)) % limit
    }
}

pub const PAGE: usize = 2_048;
pub const WORD: usize = 8;

/// What a power cut leaves of the operation that it interrupts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tear {
    /// Nothing was done.
    Nothing,
    /// Everything was done.
    All,
    /// Some bits of one word were written, and no word after it. In an erase: each word is old, or
    /// erased, or anything between.
    Random(u64),
    /// In an erase: the first and the last words of the page are erased, the rest is not.
    Ends,
    /// In an erase: all but the first and the last words of the page are erased.
    Middle,
}

/// The tears that each operation is tried with.
pub const TEARS: [Tear; 6] = [
    Tear::Nothing,
    Tear::All,
    Tear::Random(1),
    Tear::Random(2),
    Tear::Ends,
    Tear::Middle,
];

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoPower;

impl NorFlashError for NoPower {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

#[derive(Clone)]
pub struct Flash {
    bytes: Vec<u8>,
    /// Operations until the power cut, and what it leaves.
    pub cut: Option<(usize, Tear)>,
    powered: bool,
    /// Writes and erases so far.
    pub operations: usize,
    /// Bytes written so far.
    pub written: usize,
    /// Erases of each page.
    pub erases: Vec<usize>,
}

impl Flash {
    pub fn new(pages: usize) -> Self {
        Self {
            bytes: vec![0xff; pages * PAGE],
            cut: None,
            powered: true,
            operations: 0,
            written: 0,
            erases: vec![0; pages],
        }
    }

    /// Inverts these bits of a byte.
    pub fn flip(&mut self, place: usize, bits: u8) {
        self.bytes[place] ^= bits;
    }

    /// Restores the power.
    pub fn restart(mut self) -> Self {
        self.powered = true;
        self.cut = None;
        self
    }

    /// Counts an operation; returns the tear if the power fails in it.
    fn operate(&mut self) -> Result<Option<Tear>, NoPower> {
        if !self.powered {
            return Err(NoPower);
        }
        self.operations += 1;
        match &mut self.cut {
            Some((0, tear)) => {
                self.powered = false;
                Ok(Some(*tear))
            }
            Some((left, _)) => {
                *left -= 1;
                Ok(None)
            }
            None => Ok(None),
        }
    }
}

impl ErrorType for Flash {
    type Error = NoPower;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NoPower> {
        if !self.powered {
            return Err(NoPower);
        }
        let offset = offset as usize;
        bytes.copy_from_slice(&self.bytes[offset..offset + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NoPower> {
        assert!(from.is_multiple_of(PAGE as u32) && to.is_multiple_of(PAGE as u32));
        for page in from as usize / PAGE..to as usize / PAGE {
            let tear = self.operate()?;
            self.erases[page] += 1;
            let bytes = &mut self.bytes[page * PAGE..(page + 1) * PAGE];
            let ends = |at: usize| !(WORD..PAGE - 3 * WORD).contains(&at);
            match tear {
                None | Some(Tear::All) => bytes.fill(0xff),
                Some(Tear::Nothing) => {}
                Some(Tear::Random(seed)) => {
                    let mut random =
                        Random::new(seed.wrapping_mul(1 << 32) ^ self.operations as u64);
                    for word in bytes.chunks_mut(WORD) {
                        match random.below(3) {
                            0 => {}
                            1 => word.fill(0xff),
                            _ => word
                                .iter_mut()
                                .for_each(|byte| *byte |= random.below(256) as u8),
                        }
                    }
                }
                Some(tear) => {
                    for (at, byte) in bytes.iter_mut().enumerate() {
                        if ends(at) == (tear == Tear::Ends) {
                            *byte = 0xff;
                        }
                    }
                }
            }
            if tear.is_some() {
                return Err(NoPower);
            }
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NoPower> {
        let offset = offset as usize;
        assert!(offset.is_multiple_of(WORD) && bytes.len().is_multiple_of(WORD));
        let tear = self.operate()?;
        let mut random = Random::new(self.operations as u64);
        let words = bytes.len() / WORD;
        // The word in which a tear happens.
        let torn = match tear {
            None | Some(Tear::All | Tear::Middle) => words,
            Some(Tear::Nothing | Tear::Ends) => 0,
            Some(Tear::Random(seed)) => {
                random = Random::new(seed.wrapping_mul(1 << 32) ^ self.operations as u64);
                random.below(words as u64) as usize
            }
        };
        for (number, word) in bytes.chunks(WORD).enumerate().take(torn + 1) {
            let old = &mut self.bytes[offset + number * WORD..][..WORD];
            let blank = old.iter().all(|byte| *byte == 0xff);
            assert!(blank, "a word with error correction is written once");
            for (old, new) in old.iter_mut().zip(word) {
                if number < torn {
                    *old &= new;
                } else if matches!(tear, Some(Tear::Random(_))) {
                    *old &= new | random.below(256) as u8;
                }
            }
            self.written += WORD;
        }
        if tear.is_some() { Err(NoPower) } else { Ok(()) }
    }
}
