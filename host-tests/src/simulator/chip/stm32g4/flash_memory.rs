//! The chip's flash memory and its controller (RM0440, 5): pages of 2 KiB, double words of 8 bytes.
//!
//! An operation takes no time. The power can fail in any operation, and then tears it. The double
//! word at which it tears has an error of two bits.

use rsemu::core::space::RamStore;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};

const PAGE: u64 = 2_048;
const WORD: u64 = 8;

/// Bits of the control register.
const LOCK: u32 = 1 << 31;
const START: u32 = 1 << 16;
const PAGE_ERASE: u32 = 1 << 1;
const SECOND_BANK: u32 = 1 << 11;
const PROGRAM: u32 = 1;
/// Bits of the status register: a word that is not erased, and a wrong sequence.
const NOT_ERASED: u32 = 1 << 3;
const SEQUENCE: u32 = 1 << 7;
/// The keys that unlock the control register, in order.
const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];

/// What a power cut leaves of the operation that it interrupts.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Tear {
    /// Nothing was done.
    Nothing,
    /// The first half was done.
    Half,
    /// Everything was done.
    All,
}

/// A failure of the power.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// Number of the operation, from 0.
    pub at: u32,
    /// What is left of it.
    pub tear: Tear,
}

/// The memory with the state of its controller.
pub struct FlashMemory {
    bytes: Arc<RamStore>,
    /// Double words with an error of two bits, counted from the start of the memory.
    pub(super) torn: Arc<Mutex<BTreeSet<u64>>>,
    /// Bytes of a bank.
    bank: u64,
    pub(super) control: u32,
    pub(super) status: u32,
    key: u32,
    first: Option<(u64, u32)>,
    /// Writes and erases so far.
    pub operations: u32,
    /// Failure of the power that is still to come.
    pub cut: Option<Cut>,
}

impl FlashMemory {
    pub(super) fn new(bytes: Arc<RamStore>, bank: u64) -> Self {
        Self {
            bytes,
            torn: Arc::default(),
            bank,
            control: LOCK,
            status: 0,
            key: 0,
            first: None,
            operations: 0,
            cut: None,
        }
    }

    /// Locks the control register, as a reset does.
    pub(super) fn lock(&mut self) {
        self.control = LOCK;
    }

    /// Whether the power has failed.
    pub fn is_dead(&self) -> bool {
        self.cut.is_some_and(|cut| self.operations > cut.at)
    }

    /// Write of the key register.
    pub(super) fn unlock(&mut self, key: u32) {
        if [self.key, key] == KEYS {
            self.control &= !LOCK;
        }
        self.key = key;
    }

    /// Write of the control register.
    pub(super) fn set_control(&mut self, value: u32) {
        if self.control & LOCK != 0 {
            return;
        }
        self.control = value & !START;
        if value & START != 0 && value & PAGE_ERASE != 0 {
            let page = u64::from(value >> 3 & 0x7f);
            let bank = u64::from(value & SECOND_BANK != 0);
            self.change(bank * self.bank + page * PAGE, &[0xff; PAGE as usize]);
        }
    }

    /// Write of a word of the memory. The second word of a double word programs both.
    pub(super) fn program(&mut self, offset: u64, word: u32) {
        if self.control & (LOCK | PROGRAM) != PROGRAM {
            self.status |= SEQUENCE;
            return;
        }
        let Some((start, first)) = self.first.take() else {
            self.first = Some((offset, word));
            return;
        };
        let bytes = [first.to_le_bytes(), word.to_le_bytes()].concat();
        let mut old = [0; WORD as usize];
        self.bytes.read_at(start, &mut old).expect("flash memory");
        if start % WORD != 0 || offset != start + 4 {
            self.status |= SEQUENCE;
        } else if old != [0xff; 8] && bytes != [0; 8] {
            self.status |= NOT_ERASED;
        } else {
            self.change(start, &bytes);
        }
    }

    fn change(&mut self, offset: u64, bytes: &[u8]) {
        let done = match self.cut {
            _ if self.is_dead() => 0,
            Some(cut) if cut.at == self.operations => match cut.tear {
                Tear::Nothing => 0,
                Tear::Half => bytes.len() / 2,
                Tear::All => bytes.len(),
            },
            _ => bytes.len(),
        };
        self.operations += 1;
        let mut torn = self.torn.lock().expect("words");
        torn.retain(|word| !(offset..offset + done as u64).contains(&(word * WORD)));
        if (1..bytes.len()).contains(&done) {
            torn.insert((offset + done as u64) / WORD);
        }
        let memory = &self.bytes;
        memory
            .write_at(offset, &bytes[..done])
            .expect("flash memory");
    }
}
