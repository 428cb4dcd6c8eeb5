//! Computes strain and slack of B2P2's belt.

use crate::simulator::record::Sample;
use serde::Serialize;

/// Strain or slack of the belt during the climb, m; zero if the robot never climbed.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct TensionError {
    /// 99th percentile of the samples.
    pub p99: f64,
    /// Maximum.
    pub max: f64,
}

pub(super) fn tension_error(climb: &[Sample]) -> TensionError {
    let mut errors: Vec<f64> = climb
        .iter()
        .map(|sample| sample.truth.tension_error.abs())
        .collect();
    errors.sort_by(f64::total_cmp);
    TensionError {
        p99: percentile(&errors, 99),
        max: errors.last().copied().unwrap_or_default(),
    }
}

/// Nearest-rank percentile: the smallest of the values that at least `percent` % of the values do
/// not exceed. Returns 0 for an empty list.
///
/// `sorted` is in ascending order. `percent` is a whole number from 0 to 100, because rounding
/// errors of a fraction could select the next rank: in binary 0.28 x 25 is above 7.
pub fn percentile(sorted: &[f64], percent: usize) -> f64 {
    let rank = (percent * sorted.len()).div_ceil(100).max(1);
    sorted
        .get(rank - 1)
        .or(sorted.last())
        .copied()
        .unwrap_or_default()
}
