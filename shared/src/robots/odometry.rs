//! The way that a robot went by its encoders, as a sum that never grows coarse.

use crate::math::to_i32;

/// A way in whole micrometres, and what is not whole yet.
#[derive(Clone, Copy, Debug, Default)]
pub struct Odometry {
    whole: i32,
    rest: f32,
}

impl Odometry {
    /// Adds a way in um: below 2 km at once.
    #[inline]
    pub fn add(&mut self, way: f32) {
        self.rest += way;
        let whole = to_i32(self.rest);
        self.rest -= whole as f32;
        self.whole = self.whole.wrapping_add(whole);
    }

    /// The sum, um; wraps.
    pub fn um(&self) -> i32 {
        self.whole
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A millimetre an hour at 250 Hz, for ten hours.
    #[test]
    fn the_smallest_ways_are_not_lost() {
        let mut odometry = Odometry::default();
        for _ in 0..9_000_000 {
            odometry.add(1_000.0 / 900_000.0);
        }
        assert!((odometry.um() - 10_000).abs() <= 2, "{}", odometry.um());
    }

    #[test]
    fn it_wraps_like_the_counter_that_it_is() {
        let mut odometry = Odometry {
            whole: i32::MAX,
            rest: 0.0,
        };
        odometry.add(1.0);
        assert_eq!(odometry.um(), i32::MIN);
    }
}
