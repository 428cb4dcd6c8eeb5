//! Sums the distance that a robot travels by its encoders, without losing resolution.

use crate::math::to_i32;

/// Distance in whole micrometres, and the fraction that remains.
#[derive(Clone, Copy, Debug, Default)]
pub struct Odometry {
    whole: i32,
    rest: f32,
}

impl Odometry {
    /// Adds a distance in um, below 2 km in one call.
    #[inline]
    pub fn add(&mut self, way: f32) {
        self.rest += way;
        let whole = to_i32(self.rest);
        self.rest -= whole as f32;
        self.whole = self.whole.wrapping_add(whole);
    }

    /// Sum, um; wraps.
    pub fn um(&self) -> i32 {
        self.whole
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One millimetre per hour at 250 Hz, for ten hours.
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
