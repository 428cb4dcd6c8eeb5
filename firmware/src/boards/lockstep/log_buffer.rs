//! Log records on their way into the answers: bounded, never blocking, whole records or none.

use core::cell::RefCell;
use critical_section::Mutex;
use heapless::{Deque, Vec};

/// Log records that wait for an answer.
pub static LOG: Mutex<RefCell<LogBuffer>> = Mutex::new(RefCell::new(LogBuffer::new()));

/// Bytes that wait for the next answers; what comes while they are full is dropped and counted.
pub struct LogBuffer {
    bytes: Deque<u8, 4_096>,
    record: usize, // bytes of the record that is being written
    overflow: bool,
    dropped: u32,
}

impl LogBuffer {
    /// An empty buffer.
    pub const fn new() -> Self {
        Self {
            bytes: Deque::new(),
            record: 0,
            overflow: false,
            dropped: 0,
        }
    }

    /// Begins a record.
    pub fn begin(&mut self) {
        self.record = 0;
        self.overflow = false;
    }

    /// Appends to the record.
    pub fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            if self.overflow || self.bytes.push_back(*byte).is_err() {
                self.overflow = true;
                return;
            }
            self.record += 1;
        }
    }

    /// Ends the record; takes it back if it did not fit.
    pub fn end(&mut self) {
        if self.overflow {
            self.dropped = self.dropped.saturating_add(1);
            for _ in 0..self.record {
                self.bytes.pop_back();
            }
        }
    }

    /// The oldest bytes, as many as fit into one answer.
    pub fn take<const N: usize>(&mut self) -> Vec<u8, N> {
        let mut taken = Vec::new();
        while !taken.is_full() {
            let Some(byte) = self.bytes.pop_front() else {
                break;
            };
            let _ = taken.push(byte); // there is room: the loop's condition
        }
        taken
    }

    /// Records lost since the last call; 0 while there is no room to say so.
    pub fn take_dropped(&mut self) -> u32 {
        if self.bytes.is_empty() {
            core::mem::take(&mut self.dropped)
        } else {
            0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn record_that_does_not_fit_leaves_no_part_behind() {
        let mut buffer = LogBuffer::new();
        for _ in 0..5 {
            buffer.begin();
            buffer.write(&[7; 1_000]);
            buffer.end();
        }
        assert_eq!(
            (0..5)
                .map(|_| buffer.take::<1_000>().len())
                .collect::<std::vec::Vec<_>>(),
            [1_000, 1_000, 1_000, 1_000, 0]
        );
        assert_eq!(buffer.take_dropped(), 1);
        assert_eq!(buffer.take_dropped(), 0);
    }
}
