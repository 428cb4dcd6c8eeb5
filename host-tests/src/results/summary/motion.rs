//! Computes how far the robot drove, and whether it stands still at the end.

use crate::simulator::record::{SAMPLE_HZ, Sample};

/// A robot stands still if its mean speed over the last second is below this, m/s.
const STANDING_MPS: f64 = 0.01;

pub(super) fn stopped(samples: &[Sample]) -> bool {
    let last = &samples[samples.len().saturating_sub(SAMPLE_HZ as usize)..];
    !last.is_empty() && path(last) / (last.len() as f64) < STANDING_MPS
}

/// Sum of the speeds over ground of all samples, m/s; divided by the sample rate it is a distance.
pub(super) fn path(samples: &[Sample]) -> f64 {
    let speeds = samples.iter().map(|sample| sample.truth.ground_speed.abs());
    speeds.sum()
}
