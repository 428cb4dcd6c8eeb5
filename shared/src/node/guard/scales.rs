//! Compares the units of the nodes at start: the guard reads each drive's position scale (object
//! 0x2010) by SDO and compares it with the one that the robot's equations use.

use crate::can::Frame;

/// Index of the object that holds a drive's position scale (`crate::bus::scale::Scale::code`).
pub const POSITION_SCALE: u16 = 0x2010;
/// Time after which an unanswered request is repeated.
const RETRY_US: u64 = 100_000;

const SDO_REQUEST: u16 = 0x600;
pub(super) const SDO_RESPONSE: u16 = 0x580;

/// What the guard knows of one drive's position scale.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct ScaleReader {
    asked_us: Option<u64>,
    found: Option<u16>,
}

impl ScaleReader {
    /// Returns the request to send to drive `id` now, if one is due.
    pub fn request(&mut self, id: u8, now_us: u64) -> Option<Frame> {
        let waits = self
            .asked_us
            .is_some_and(|asked| now_us.saturating_sub(asked) < RETRY_US);
        if self.found.is_some() || waits {
            return None;
        }
        self.asked_us = Some(now_us);
        let [low, high] = POSITION_SCALE.to_le_bytes();
        Frame::new(
            SDO_REQUEST + u16::from(id),
            &[0x40, low, high, 0, 0, 0, 0, 0],
        )
    }

    /// Takes a frame of drive `id`, and returns whether it is the answer. For a drive without the
    /// object the scale is 0, which no drive has. Not inlined: it is rare, and the compiler would
    /// then not inline what every frame needs.
    #[cold]
    #[inline(never)]
    pub fn receive(&mut self, frame: &Frame, id: u8) -> bool {
        let [low, high] = POSITION_SCALE.to_le_bytes();
        if frame.id() != SDO_RESPONSE + u16::from(id) {
            return false;
        }
        match *frame.data() {
            // Expedited upload of two bytes.
            [0x4b, l, h, 0, a, b, ..] if (l, h) == (low, high) => {
                self.found = Some(u16::from_le_bytes([a, b]));
                true
            }
            // An answer of another size, or "no such object". After any other abort the request is
            // repeated.
            [0x40..=0x5f, l, h, 0, ..] | [0x80, l, h, 0, 0, 0, 2, 6] if (l, h) == (low, high) => {
                self.found = Some(0);
                true
            }
            _ => false,
        }
    }

    /// Returns the scale of the drive; `None` before it answered.
    pub fn found(&self) -> Option<u16> {
        self.found
    }

    /// Forgets the answer, because the drive has restarted.
    pub fn forget(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_repeated_until_it_is_answered() {
        let mut reader = ScaleReader::default();
        let request = reader.request(4, 0).unwrap();
        assert_eq!(
            (request.id(), request.data()),
            (0x604, &[0x40, 0x10, 0x20, 0, 0, 0, 0, 0][..])
        );
        assert_eq!(reader.request(4, 99_999), None);
        assert!(reader.request(4, 100_000).is_some());
        reader.receive(
            &Frame::new(0x585, &[0x4b, 0x10, 0x20, 0, 32, 0]).unwrap(),
            4,
        );
        assert_eq!(reader.found(), None, "another drive's answer");
        reader.receive(
            &Frame::new(0x584, &[0x4b, 0x10, 0x20, 0, 32, 0]).unwrap(),
            4,
        );
        assert_eq!(reader.found(), Some(32));
        assert_eq!(reader.request(4, 1_000_000), None);
    }

    #[test]
    fn an_answer_of_another_size_is_no_scale_and_is_not_asked_for_again() {
        for first in [0x4f, 0x43, 0x41] {
            let mut reader = ScaleReader::default();
            reader.request(4, 0);
            let answer = Frame::new(0x584, &[first, 0x10, 0x20, 0, 32, 0, 0, 0]).unwrap();
            assert!(reader.receive(&answer, 4));
            assert_eq!(reader.found(), Some(0));
            assert_eq!(reader.request(4, 1_000_000), None);
        }
    }

    #[test]
    fn an_answer_about_another_object_is_no_scale() {
        for first in [0x4b, 0x4f, 0x80] {
            for object in [[0x11, 0x20], [0x10, 0x21]] {
                let [low, high] = object;
                let mut reader = ScaleReader::default();
                reader.request(4, 0);
                let answer = Frame::new(0x584, &[first, low, high, 0, 0, 0, 2, 6]).unwrap();
                assert!(!reader.receive(&answer, 4), "{first:#x} {object:?}");
                assert_eq!(reader.found(), None);
            }
        }
    }
}
