//! Smooths the difference of zero moment point and centre of gravity.

use super::Moment;
use crate::simulator::record::SAMPLE_HZ;
use std::collections::VecDeque;

/// Standard deviation of the Gaussian that smooths the difference, s.
pub const SMOOTHING_S: f64 = 0.15;
/// Number of samples before and after a sample that take part: three standard deviations.
const REACH: usize = (3.0 * SMOOTHING_S * SAMPLE_HZ as f64) as usize;

/// Computes the Gaussian mean of the differences within three standard deviations, [`REACH`]
/// samples late.
#[derive(Default)]
pub(super) struct Smoothing {
    /// Times, s, and moments of the samples around the next one to smooth.
    window: VecDeque<(f64, Option<Moment>)>,
    /// Place of the next one to smooth in the window.
    next: usize,
}

impl Smoothing {
    /// Adds a moment. Returns the smoothed ones that are due, in the same order: at most one.
    pub fn add(&mut self, time_s: f64, moment: Option<Moment>) -> Vec<Option<Moment>> {
        self.window.push_back((time_s, moment));
        let due = self.window.len() > self.next + REACH;
        due.then(|| self.smooth()).into_iter().collect()
    }

    /// Returns the smoothed moments that are left at the end of the run.
    pub fn finish(mut self) -> Vec<Option<Moment>> {
        let left = self.window.len() - self.next;
        (0..left).map(|_| self.smooth()).collect()
    }

    fn smooth(&mut self) -> Option<Moment> {
        let (time_s, moment) = self.window[self.next];
        let from = self.next.saturating_sub(REACH);
        let to = (self.next + REACH + 1).min(self.window.len());
        let smoothed = moment.map(|moment| {
            let (mut sum, mut weights) = (0.0, 0.0);
            for (other_s, other) in self.window.range(from..to) {
                if let Some(difference) = other.as_ref().and_then(Moment::difference) {
                    let distance = (other_s - time_s) / SMOOTHING_S;
                    let weight = libm::exp(-0.5 * distance * distance);
                    sum += weight * difference;
                    weights += weight;
                }
            }
            Moment {
                smoothed: (weights > 0.0).then(|| sum / weights),
                ..moment
            }
        });
        if self.next == REACH {
            self.window.pop_front();
        } else {
            self.next += 1;
        }
        smoothed
    }
}
