//! Upper percentiles of a series of any length.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Number of values that are kept.
const KEPT: usize = 65_536;

/// The largest values of a series of numbers that are not negative.
///
/// Memory: at most 0.5 MB, whatever the length.
#[derive(Clone, Debug, Default)]
pub struct Largest {
    /// Bits of the values. Without a sign they have the order of the values, NaN last.
    kept: BinaryHeap<Reverse<u64>>,
    count: usize,
}

impl Largest {
    /// Adds the absolute value of a number.
    pub fn add(&mut self, value: f64) {
        self.count += 1;
        let bits = value.abs().to_bits();
        if self.kept.len() < KEPT {
            self.kept.push(Reverse(bits));
        } else if let Some(mut least) = self.kept.peek_mut()
            && least.0 < bits
        {
            *least = Reverse(bits);
        }
    }

    /// Nearest-rank percentile: the smallest of the values that at least `percent` % of the values
    /// do not exceed. Returns 0 for an empty series.
    ///
    /// `percent` is a whole number from 0 to 100, because rounding errors of a fraction could
    /// select the next rank: in binary 0.28 x 25 is above 7.
    ///
    /// Exact for any percentile of up to 65 536 values, and for the 99th of up to 6.5 million: 18
    /// hours of samples. Of a longer series it is the smallest value that was kept, which is too
    /// large.
    pub fn percentile(&self, percent: usize) -> f64 {
        let rank = (percent * self.count).div_ceil(100).max(1);
        let larger = self.count.saturating_sub(rank);
        let descending = self.kept.clone().into_sorted_vec();
        let found = descending.get(larger).or(descending.last());
        found.map_or(0.0, |bits| f64::from_bits(bits.0))
    }
}
