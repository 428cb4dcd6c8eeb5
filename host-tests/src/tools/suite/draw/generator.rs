//! The random number generator of all draws: a counter whose values pass through a mixing function.

use crate::world::noise::mix;

/// A stream of random numbers, determined by its initial value.
pub struct Random(u64);

impl Random {
    /// The stream that belongs to `keys` in this order.
    pub fn new(keys: &[u64]) -> Self {
        Self(keys.iter().fold(0, |state, key| mix(state ^ key)))
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(1);
        mix(self.0)
    }

    /// A number, uniform between the bounds, in steps of 0.001, so that a scenario file shows its
    /// exact value.
    pub fn between(&mut self, least: f64, most: f64) -> f64 {
        (1e3 * (least + (most - least) * self.share())).round() / 1e3
    }

    /// A number, uniform between 0 and 1.
    fn share(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.share() < probability
    }

    /// True or false, equally likely.
    pub fn coin(&mut self) -> bool {
        self.bits() & 1 == 0
    }

    /// 1 or -1, equally likely.
    pub fn sign(&mut self) -> f64 {
        if self.coin() { 1.0 } else { -1.0 }
    }

    /// A whole number from 0 to `count` - 1, or 0 if `count` is 0.
    pub fn below(&mut self, count: u64) -> u64 {
        self.bits().checked_rem(count).unwrap_or(0)
    }

    /// One of the items, with a probability in proportion to its weight; `None` without items.
    pub fn weighted<T: Copy>(&mut self, items: &[(T, f64)]) -> Option<T> {
        let total: f64 = items.iter().map(|(_, weight)| weight).sum();
        let mut left = total * self.share();
        for (item, weight) in items {
            left -= weight;
            if left < 0.0 {
                return Some(*item);
            }
        }
        items.last().map(|(item, _)| *item)
    }
}
