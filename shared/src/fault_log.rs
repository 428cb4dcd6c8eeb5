//! The last faults of a node, with what was measured when they came. A board keeps them over a
//! reset in RAM that nothing initialises: a checksum shows whether it holds a log.

use crate::math::Crc32;

/// Maximum number of faults in a log.
pub const ENTRIES: usize = 8;
/// Words of a log as a board keeps it: number of faults, four words for each, and the checksum.
pub const WORDS: usize = 4 * ENTRIES + 2;

/// Cause of a reset.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Reset {
    /// The board cannot know it.
    Unknown = 0,
    /// Power-up, or a drop of the supply.
    Power = 1,
    /// The reset pin.
    Pin = 2,
    /// A command.
    Software = 3,
    /// The watchdog.
    Watchdog = 4,
    /// The watchdog, after the crystal or the program had failed.
    Crash = 5,
    /// The option bytes, or a low-power mode.
    Other = 6,
}

/// What a node measured when a fault came.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Circumstances {
    /// Supply voltage, V.
    pub supply_voltage: f32,
    /// Motor current, A.
    pub current: f32,
    /// Velocity of the output shaft, rad/s.
    pub velocity: f32,
}

/// A fault. Values beyond the range of a field have its largest or smallest one.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Entry {
    /// Its code.
    pub code: u16,
    /// Cause of the last reset before it: a [`Reset`].
    pub reset: u8,
    /// Time since this reset, ms.
    pub time: u32,
    /// Supply voltage, mV.
    pub supply_voltage: u16,
    /// Motor current, mA.
    pub current: i16,
    /// Velocity of the output shaft, mrad/s.
    pub velocity: i32,
}

impl Entry {
    fn to_words(self) -> [u32; 4] {
        let current = u32::from(self.current.cast_unsigned());
        [
            u32::from(self.reset) << 16 | u32::from(self.code),
            self.time,
            current << 16 | u32::from(self.supply_voltage),
            self.velocity.cast_unsigned(),
        ]
    }

    fn from_words([first, time, third, velocity]: [u32; 4]) -> Self {
        Self {
            code: first as u16,
            reset: (first >> 16) as u8,
            time,
            supply_voltage: third as u16,
            current: (third >> 16) as i16,
            velocity: velocity.cast_signed(),
        }
    }

    /// The error as object 0x1003 has it: the code, and above it the cause of the reset.
    pub fn error(&self) -> u32 {
        self.to_words()[0]
    }
}

/// The last faults, the newest first.
#[derive(Clone, Debug, Default)]
pub struct FaultLog {
    entries: heapless::Deque<Entry, ENTRIES>,
    reset: u8,
    changed: bool,
}

impl FaultLog {
    /// Creates a log from the words that [`Self::to_words`] returned before a reset, with the
    /// cause of this reset, a [`Reset`]. It is empty if the words are no log.
    pub fn new(words: &[u32; WORDS], reset: u8) -> Self {
        let mut log = Self {
            reset,
            ..Self::default()
        };
        let [count, entries @ .., checksum] = words;
        if checksum_of(*count, entries) == *checksum {
            let count = Ord::min(*count as usize, ENTRIES);
            for words in entries.as_chunks().0.iter().take(count) {
                // Cannot fail: there is room.
                let _ = log.entries.push_back(Entry::from_words(*words));
            }
        }
        log
    }

    /// Returns the words that a board keeps.
    pub fn to_words(&self) -> [u32; WORDS] {
        let mut words = [0; WORDS];
        let [count, entries @ .., checksum] = &mut words;
        *count = self.entries.len() as u32;
        for (place, entry) in entries.as_chunks_mut().0.iter_mut().zip(&self.entries) {
            *place = entry.to_words();
        }
        *checksum = checksum_of(*count, entries);
        words
    }

    /// Adds a fault, at this time since the reset. The oldest one makes room.
    pub fn add(&mut self, code: u16, time: u32, measured: &Circumstances) {
        if self.entries.is_full() {
            self.entries.pop_back();
        }
        let milli = |value: f32| 1e3 * value;
        // Cannot fail: there is room. A conversion to an integer saturates, and that of NaN is 0.
        let _ = self.entries.push_front(Entry {
            code,
            reset: self.reset,
            time,
            supply_voltage: milli(measured.supply_voltage) as u16,
            current: milli(measured.current) as i16,
            velocity: milli(measured.velocity) as i32,
        });
        self.changed = true;
    }

    /// Removes all faults.
    pub fn clear(&mut self) {
        self.entries.clear();
        self.changed = true;
    }

    /// Number of faults.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there is no fault.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Returns a fault; 0 is the newest one.
    pub fn get(&self, number: usize) -> Option<&Entry> {
        self.entries.get(number)
    }

    /// Returns whether the faults have changed since the last call.
    pub fn take_changed(&mut self) -> bool {
        core::mem::take(&mut self.changed)
    }
}

fn checksum_of(count: u32, entries: &[u32]) -> u32 {
    let checksum = Crc32::of(&count.to_le_bytes());
    let words = entries.iter().map(|word| word.to_le_bytes());
    words
        .fold(checksum, |checksum, bytes| checksum.with(&bytes))
        .value()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log_of(count: u16) -> FaultLog {
        let mut log = FaultLog::new(&[0; WORDS], Reset::Watchdog as u8);
        for code in 1..=count {
            let measured = Circumstances {
                supply_voltage: 24.5,
                current: -1.25,
                velocity: -2.0,
            };
            log.add(code, u32::from(code) * 10, &measured);
        }
        log
    }

    #[test]
    fn a_log_survives_as_words_with_the_newest_eight_faults() {
        for count in 0..12 {
            let log = log_of(count);
            let kept = FaultLog::new(&log.to_words(), Reset::Power as u8);
            assert_eq!(kept.len(), usize::from(count).min(ENTRIES));
            for number in 0..kept.len() {
                let code = count - number as u16;
                let expected = Entry {
                    code,
                    reset: Reset::Watchdog as u8,
                    time: u32::from(code) * 10,
                    supply_voltage: 24_500,
                    current: -1_250,
                    velocity: -2_000,
                };
                assert_eq!(kept.get(number), Some(&expected));
            }
        }
    }

    #[test]
    fn words_with_a_wrong_bit_and_words_of_chance_are_no_log() {
        let words = log_of(3).to_words();
        for bit in 0..32 * WORDS {
            let mut wrong = words;
            wrong[bit / 32] ^= 1 << (bit % 32);
            assert!(
                FaultLog::new(&wrong, Reset::Power as u8).is_empty(),
                "{bit}"
            );
        }
        for word in [0, u32::MAX, 0x5a5a_5a5a] {
            assert!(FaultLog::new(&[word; WORDS], Reset::Power as u8).is_empty());
        }
    }
}
