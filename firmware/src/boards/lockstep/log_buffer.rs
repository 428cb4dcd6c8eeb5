//! Buffers log records until an answer to the simulator carries them. The buffer is bounded and
//! never blocks; a record is stored whole or not at all.

use heapless::{Deque, Vec};

/// Buffer for the log bytes of the next answers. While it is full, new records are dropped and
/// counted.
pub struct LogBuffer {
    bytes: Deque<u8, 4_096>,
    record: usize, // bytes of the record being written
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

    /// Appends `bytes` to the record.
    pub fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            if self.overflow || self.bytes.push_back(*byte).is_err() {
                self.overflow = true;
                return;
            }
            self.record += 1;
        }
    }

    /// Ends the record; removes it again if it did not fit.
    pub fn end(&mut self) {
        if self.overflow {
            self.dropped = self.dropped.saturating_add(1);
            for _ in 0..self.record {
                self.bytes.pop_back();
            }
        }
    }

    /// Moves the oldest bytes to `taken`, as many as fit.
    pub fn take<const N: usize>(&mut self, taken: &mut Vec<u8, N>) {
        while !taken.is_full() {
            let Some(byte) = self.bytes.pop_front() else {
                break;
            };
            let _ = taken.push(byte); // cannot fail: see the loop's condition
        }
    }

    /// Returns and clears the count of lost records. Returns 0 while the buffer holds bytes,
    /// because the message about the loss might not fit.
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
        for length in [1_000, 1_000, 1_000, 1_000, 0] {
            let mut taken = Vec::<u8, 1_000>::new();
            buffer.take(&mut taken);
            assert_eq!(taken.len(), length);
        }
        assert_eq!(buffer.take_dropped(), 1);
        assert_eq!(buffer.take_dropped(), 0);
    }
}
