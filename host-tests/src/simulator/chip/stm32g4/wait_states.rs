//! Time for which the core waits for the flash memory (RM0440, 5.3.3 and 5.3.4): the memory gives
//! 64 bits at a time, after the wait states of the register ACR. Three parts shorten this:
//!
//! * The 64 bits of instructions that were read last need no reading.
//! * The prefetch reads the next 64 bits while the core executes these.
//! * The caches keep what the core has waited for: 32 lines of instructions and 8 of data, each of
//!   four times 64 bits. The line that was not used for the longest time makes room.
//!
//! A chip counts them from [`super::Chip::count_wait_states`] on.
//!
//! Not modelled: accesses of the core ahead of the instruction that it executes, which shorten the
//! waiting, and the other masters of the bus. Never compared with silicon.

use rsemu::core::space::{AccessConstraints, MemAttrs, MemOps, MemResult, RamStore};
use std::collections::BTreeSet;
use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};

/// Number of no word.
const NONE: u32 = u32::MAX;

/// Bits of the register ACR.
const WAIT_STATES: u32 = 0xf;
const PREFETCH: u32 = 1 << 8;
const INSTRUCTION_CACHE: u32 = 1 << 9;
const DATA_CACHE: u32 = 1 << 10;

/// Line of a cache.
#[derive(Clone, Copy)]
struct Line {
    /// Number of its first word, divided by 4.
    tag: u32,
    /// Which of its words it has.
    has: u8,
    /// Clock of its last use.
    used: u64,
}

struct Cache<const LINES: usize>([Line; LINES]);

impl<const LINES: usize> Cache<LINES> {
    const EMPTY: Self = Self(
        [Line {
            tag: NONE,
            has: 0,
            used: 0,
        }; LINES],
    );

    /// Whether the cache has this word. Using it keeps it.
    fn has(&mut self, word: u32, clock: u64) -> bool {
        let line = self.0.iter_mut().find(|line| line.tag == word / 4);
        line.is_some_and(|line| {
            line.used = clock;
            line.has >> (word % 4) & 1 != 0
        })
    }

    fn add(&mut self, word: u32, clock: u64) {
        let found = self.0.iter().position(|line| line.tag == word / 4);
        let oldest = (0..LINES).min_by_key(|line| self.0[*line].used);
        let line = &mut self.0[found.or(oldest).unwrap_or(0)];
        if found.is_none() {
            (line.tag, line.has) = (word / 4, 0);
        }
        line.has |= 1 << (word % 4);
        line.used = clock;
    }
}

/// Interface of the flash memory. Words have 64 bits and are counted from its start.
struct Interface {
    control: u32,
    /// Clock of the present access, with what the core has waited.
    clock: u64,
    waited: u64,
    /// Clock at which the memory can begin to read.
    idle: u64,
    /// Word that the prefetch reads or has read.
    ahead: u32,
    instructions: Cache<32>,
    data: Cache<8>,
}

impl Interface {
    fn wait_until(&mut self, clock: u64) {
        let wait = clock.saturating_sub(self.clock);
        self.waited += wait;
        self.clock += wait;
    }

    /// Reads a word. The core itself counts one clock for an access.
    fn read(&mut self) {
        self.wait_until(self.idle);
        self.wait_until(self.clock + u64::from(self.control & WAIT_STATES));
        self.idle = self.clock;
    }

    fn fetch(&mut self, word: u32) {
        let cached = self.control & INSTRUCTION_CACHE != 0;
        if self.ahead == word {
            self.wait_until(self.idle);
        } else if !(cached && self.instructions.has(word, self.clock)) {
            self.read();
            self.instructions.add(word, self.clock);
        }
        let next = word + 1;
        let prefetches = self.control & PREFETCH != 0 && self.ahead != next;
        if prefetches && !(cached && self.instructions.has(next, self.clock)) {
            let begin = self.idle.max(self.clock);
            self.idle = begin + u64::from(self.control & WAIT_STATES) + 1;
            self.ahead = next;
        }
    }

    fn load(&mut self, word: u32) {
        if !(self.control & DATA_CACHE != 0 && self.data.has(word, self.clock)) {
            self.read();
            self.data.add(word, self.clock);
        }
    }
}

/// Flash memory as the core reads it.
pub(super) struct TimedFlash {
    bytes: Arc<RamStore>,
    /// Words with an error of two bits, and whether the core has read one.
    torn: Arc<Mutex<BTreeSet<u64>>>,
    error: AtomicBool,
    counts: AtomicBool,
    /// Word of instructions that was read last.
    current: AtomicU32,
    interface: Mutex<Interface>,
}

impl fmt::Debug for TimedFlash {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "flash memory with wait states")
    }
}

impl TimedFlash {
    pub fn new(bytes: Arc<RamStore>, torn: Arc<Mutex<BTreeSet<u64>>>) -> Self {
        Self {
            bytes,
            torn,
            error: AtomicBool::new(false),
            counts: AtomicBool::new(false),
            current: AtomicU32::new(NONE),
            interface: Mutex::new(Interface {
                control: 0,
                clock: 0,
                waited: 0,
                idle: 0,
                ahead: NONE,
                instructions: Cache::EMPTY,
                data: Cache::EMPTY,
            }),
        }
    }

    /// Counts the wait states from now on.
    pub fn count(&self) {
        self.counts.store(true, Ordering::Relaxed);
    }

    /// Begins an instruction: with the register ACR, and the clock.
    pub fn begin(&self, control: u32, clock: u64) {
        let mut interface = self.interface.lock().expect("an interface");
        (interface.control, interface.clock) = (control, clock);
    }

    /// Whether the core has read a word with an error since the last call.
    pub fn take_error(&self) -> bool {
        self.error.load(Ordering::Relaxed) && self.error.swap(false, Ordering::Relaxed)
    }

    /// Clocks that the core has waited since the last call.
    pub fn take_waited(&self) -> u64 {
        std::mem::take(&mut self.interface.lock().expect("an interface").waited)
    }
}

impl MemOps for TimedFlash {
    fn read(&self, offset: u64, bytes: &mut [u8], attributes: MemAttrs) -> MemResult {
        let word = (offset / 8) as u32;
        if !self.counts.load(Ordering::Relaxed) {
            // No waiting.
        } else if !attributes.is_fetch() {
            self.interface.lock().expect("an interface").load(word);
        } else if self.current.swap(word, Ordering::Relaxed) != word {
            self.interface.lock().expect("an interface").fetch(word);
        }
        if !attributes.is_fetch() && self.torn.lock().expect("words").contains(&word.into()) {
            self.error.store(true, Ordering::Relaxed);
        }
        self.bytes.read_at(offset, bytes).expect("flash memory");
        Ok(())
    }

    fn write(&self, _: u64, _: &[u8], _: MemAttrs) -> MemResult {
        unreachable!("stores go elsewhere")
    }

    fn constraints(&self) -> AccessConstraints {
        AccessConstraints::ANY
    }
}
