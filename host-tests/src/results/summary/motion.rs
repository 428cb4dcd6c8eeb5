//! Computes how far the robot drove, and whether it stands still at the end.

use crate::simulator::record::{SAMPLE_HZ, Sample};
use std::collections::VecDeque;

/// A robot stands still if its mean speed over the last second is below this, m/s.
const STANDING_MPS: f64 = 0.01;

/// Speeds over ground so far.
#[derive(Default)]
pub(super) struct Motion {
    /// Sum of the speeds of all samples, m/s.
    sum: f64,
    /// Speeds of the last second, m/s.
    last: VecDeque<f64>,
}

impl Motion {
    pub fn add(&mut self, sample: &Sample) {
        let speed = sample.truth.ground_speed.abs();
        self.sum += speed;
        if self.last.len() == SAMPLE_HZ as usize {
            self.last.pop_front();
        }
        self.last.push_back(speed);
    }

    /// Distance driven, forward and backward added, m.
    pub fn driven_m(&self) -> f64 {
        self.sum / f64::from(SAMPLE_HZ)
    }

    /// Whether the robot stood still during the last second.
    pub fn stopped(&self) -> bool {
        let sum: f64 = self.last.iter().sum();
        !self.last.is_empty() && sum / (self.last.len() as f64) < STANDING_MPS
    }
}
