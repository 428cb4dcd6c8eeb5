//! Index of an incremental encoder: a pulse where the rotor is at one known angle.
//!
//! The first pulse after an alignment replaces the aligned angle by the calibrated one, which has
//! no error by friction or load. Each later pulse must come at the same count; otherwise the
//! encoder has lost counts. A rotor that turns without a pulse shows a broken line.

use super::rotor::{ElectricalAngle, Mounting, Rotor, Turn};

/// Largest error of an alignment: 20 electrical degrees.
const LARGEST_ERROR: u32 = (1 << 30) / 9 * 2;
/// Counts by which a pulse may be displaced: it has a width, and begins at its other end if the
/// rotor turns back.
const WIDTH: u32 = 5;

/// Control periods after a correction of the angle in which the voltages are those of a jump.
const SETTLING: u8 = 10;

/// What the index shows.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Finding {
    /// Nothing: there is no index, the rotor was not aligned, or no pulse came since.
    #[default]
    Nothing,
    /// The rotor's angle is the calibrated one.
    Confirmed,
    /// The aligned angle, or the calibrated one, is wrong by more than 20 electrical degrees.
    Misaligned,
    /// Counts or pulses are lost: a pulse came at another count than the first one, or none
    /// came in a turn.
    Lost,
}

/// State of the index.
#[derive(Clone, Debug)]
pub(super) struct Index {
    /// Electrical angle at the pulse.
    stored: ElectricalAngle,
    /// Electrical angle of [`WIDTH`] counts.
    width: u32,
    /// Counts per turn.
    counts: u32,
    /// Count of the rotor sensor at the newest pulse, and whether it was not evaluated yet.
    pulse: Option<u32>,
    new: bool,
    /// Count at the alignment or at the newest pulse after it, once the rotor is aligned.
    last: Option<u32>,
    /// Count within a turn at the pulse that confirmed the angle.
    confirmed: Option<u32>,
    /// Control periods that are left of [`SETTLING`].
    settling: u8,
}

impl Index {
    /// Creates the index of an encoder. The electrical angle at count 0 is that at the pulse.
    pub fn new(mounting: Mounting) -> Self {
        let origin = Rotor::new(mounting);
        let count = (origin.angle(1).0 - origin.angle(0).0).to_bits();
        Self {
            stored: mounting.offset,
            width: count.unsigned_abs().saturating_mul(WIDTH),
            counts: mounting.counts_per_turn.unsigned_abs(),
            pulse: None,
            new: false,
            last: None,
            confirmed: None,
            settling: 0,
        }
    }

    /// Takes a pulse at this count of the rotor sensor.
    pub fn pulse(&mut self, count: u32) {
        (self.pulse, self.new) = (Some(count), true);
    }

    /// Returns the count at the newest pulse since power-up.
    pub fn newest(&self) -> Option<u32> {
        self.pulse
    }

    /// Returns whether the angle was corrected a few control periods ago. Counts this one.
    pub fn settles(&mut self) -> bool {
        let settles = self.settling > 0;
        self.settling = self.settling.saturating_sub(1);
        settles
    }

    /// The rotor was aligned.
    pub fn align(&mut self, turn: &Turn) {
        (self.last, self.confirmed, self.new) = (Some(turn.reading()), None, false);
    }

    /// Evaluates a control period, and corrects the angle at the first pulse after an alignment.
    /// `turn` is current if the motor was `driven`.
    pub fn update(&mut self, rotor: &mut Rotor, turn: &Turn, driven: bool) -> Finding {
        let Some(last) = self.last else {
            return Finding::Nothing;
        };
        if let (Some(pulse), true) = (self.pulse, core::mem::take(&mut self.new)) {
            self.last = Some(pulse);
            let count = turn.within(pulse);
            if let Some(confirmed) = self.confirmed {
                let apart = count.abs_diff(confirmed);
                if apart.min(self.counts.saturating_sub(apart)) > WIDTH {
                    return Finding::Lost;
                }
            } else {
                let error = self.stored.0 - rotor.angle(count).0;
                if error.to_bits().unsigned_abs() > self.width.saturating_add(LARGEST_ERROR) {
                    return Finding::Misaligned;
                }
                rotor.correct(ElectricalAngle(error));
                self.confirmed = Some(count);
                self.settling = SETTLING;
            }
        } else if driven {
            let moved = turn.reading().wrapping_sub(last) as i32;
            if moved.unsigned_abs() > self.counts.saturating_add(WIDTH) {
                return Finding::Lost;
            }
        }
        if self.confirmed.is_some() {
            Finding::Confirmed
        } else {
            Finding::Nothing
        }
    }
}
