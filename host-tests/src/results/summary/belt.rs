//! Strain and slack of B2P2's belt.

use crate::simulator::record::Sample;
use serde::Serialize;

/// Strain or slack of the belt; zero when the run never climbed.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct TensionError {
    /// 99 % of the samples are at most this.
    pub p99: f64,
    /// Largest.
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

/// Nearest-rank percentile: the least value that at least `percent` % of the values do not exceed;
/// 0 of nothing. `sorted` ascends; `percent` is 0 to 100, and whole, because 0.28 x 25 is above 7
/// in binary.
pub fn percentile(sorted: &[f64], percent: usize) -> f64 {
    let rank = (percent * sorted.len()).div_ceil(100).max(1);
    sorted
        .get(rank - 1)
        .or(sorted.last())
        .copied()
        .unwrap_or_default()
}
