//! How far the robot drove, and whether it stands.

use crate::simulator::record::{SAMPLE_HZ, Sample};

/// Slower than this on average over the last second is standing still, m/s.
const STANDING_MPS: f64 = 0.01;

pub(super) fn stopped(samples: &[Sample]) -> bool {
    let last = &samples[samples.len().saturating_sub(SAMPLE_HZ as usize)..];
    !last.is_empty() && path(last) / (last.len() as f64) < STANDING_MPS
}

/// Sum of the speeds over ground.
pub(super) fn path(samples: &[Sample]) -> f64 {
    let speeds = samples.iter().map(|sample| sample.truth.ground_speed.abs());
    speeds.sum()
}
