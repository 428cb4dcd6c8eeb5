//! Finds steps of an encoder that no shaft can make: interference on its lines.

/// Score of an impossible step, and the score at which the encoder is noisy: three impossible steps
/// within a few control periods. One disturbed sample makes two of them, forth and back.
const STEP: u8 = 10;
const NOISY: u8 = 25;

/// Counts impossible steps.
#[derive(Clone, Debug)]
pub struct EncoderSteps {
    last: i32,
    /// Largest step in a control period that the shaft can make, counts.
    largest: u32,
    score: u8,
}

impl EncoderSteps {
    /// Creates the watch of an encoder that moves by at most `largest` counts in a control period.
    pub fn new(largest: f32) -> Self {
        let mut steps = Self {
            last: 0,
            largest: 0,
            score: 0,
        };
        steps.set_largest(largest);
        steps
    }

    /// Sets the largest step, counts.
    pub fn set_largest(&mut self, largest: f32) {
        // Rounding at both ends of a step.
        self.largest = (largest as u32).saturating_add(2);
    }

    /// Takes the reading `counts` as the first one.
    pub fn start(&mut self, counts: i32) {
        self.last = counts;
    }

    /// Takes the next reading.
    #[inline]
    pub fn update(&mut self, counts: i32) {
        let step = counts.wrapping_sub(self.last);
        self.last = counts;
        self.score = if step.unsigned_abs() > self.largest {
            self.score.saturating_add(STEP)
        } else {
            self.score.saturating_sub(1)
        };
    }

    /// Returns whether a step of the last ten control periods was impossible.
    pub fn is_doubtful(&self) -> bool {
        self.score > 0
    }

    /// Returns whether the encoder is noisy.
    pub fn is_noisy(&self) -> bool {
        self.score >= NOISY
    }
}
