//! Estimates position and velocity of the output shaft from an incremental encoder on the rotor.

use super::to_radians;

/// Tracking observer of second order. Its velocity is smooth although the encoder's counts are not.
///
/// The position that it returns is the encoder's own, exact to a count; only the velocity is
/// filtered. The bandwidth is that of a critically damped loop: after a step of the velocity, the
/// estimate settles to 5 % within about `4.7 / bandwidth` seconds.
#[derive(Clone, Debug)]
pub struct Observer {
    counts: i32,
    /// Turn of the output shaft per count, 2^-32 turn, with 16 fraction bits.
    unit_per_count: i64,
    measured: Fixed,
    /// How far the estimated position lags behind the measured one, rad. It is a small number, for
    /// which single precision is enough.
    lag: f32,
    velocity: f32,
    bandwidth: f32,
}

/// Position with 16 additional fraction bits. So a gear ratio that is no power of two causes no
/// growing error.
#[derive(Clone, Copy, Debug, Default)]
struct Fixed {
    whole: i64,
    fraction: i64,
}

impl Observer {
    /// Creates an observer of an encoder with `counts` per rotor turn, behind a gear of
    /// `gear_milli` / 1000 rotor turns per output turn. The bandwidth is in rad/s, and `now` is the
    /// present reading of the encoder.
    pub fn new(counts: i32, gear_milli: i32, bandwidth: f32, now: i32) -> Self {
        let counts_per_turn_milli = i128::from(counts.max(1)) * i128::from(gear_milli.max(1));
        // The only division. It runs once, at start.
        let unit_per_count =
            ((1_i128 << 48) * 1_000 + counts_per_turn_milli / 2) / counts_per_turn_milli;
        Self {
            counts: now,
            unit_per_count: unit_per_count as i64,
            measured: Fixed::default(),
            lag: 0.0,
            velocity: 0.0,
            bandwidth,
        }
    }

    /// Sets the encoder's reading at the present position to `counts`, as [`Self::new`] does.
    pub fn start(&mut self, counts: i32) {
        self.counts = counts;
    }

    /// Updates the estimate with the encoder's wrapping counter, `period` seconds after the
    /// previous call.
    pub fn update(&mut self, counts: i32, period: f32) {
        let step = i64::from(counts.wrapping_sub(self.counts));
        self.counts = counts;
        let moved = step
            .wrapping_mul(self.unit_per_count)
            .wrapping_add(self.measured.fraction);
        let whole = moved >> 16;
        self.measured.whole = self.measured.whole.wrapping_add(whole);
        self.measured.fraction = moved & 0xffff;

        let error = self.lag + to_radians(whole) - self.velocity * period;
        self.lag = error - error * (2.0 * self.bandwidth * period);
        self.velocity += error * (self.bandwidth * self.bandwidth * period);
    }

    /// Returns the measured position, 2^-32 turn of the output shaft.
    pub fn position(&self) -> i64 {
        self.measured.whole
    }

    /// Returns the estimated velocity, rad/s of the output shaft.
    pub fn velocity(&self) -> f32 {
        self.velocity
    }

    /// Defines the present position as `position`, 2^-32 turn of the output shaft.
    pub fn set_position(&mut self, position: i64) {
        self.measured.whole = position;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn velocity_settles_on_a_constant_speed_between_counts() {
        let mut observer = Observer::new(4_096, 60_000, 600.0, 0);
        let counts_per_radian = 4_096.0 * 60.0 / core::f64::consts::TAU;
        for step in 1..=200 {
            let counts = 0.5 * f64::from(step) * 1e-3 * counts_per_radian;
            observer.update(counts as i32, 1e-3);
        }
        assert!(
            (observer.velocity() - 0.5).abs() < 0.01,
            "{}",
            observer.velocity()
        );
    }

    #[test]
    fn a_billion_counts_forth_and_back_end_at_zero() {
        let mut observer = Observer::new(4_095, 66_667, 600.0, i32::MAX - 5);
        let mut counts = i32::MAX - 5;
        for _ in 0..10_000 {
            counts = counts.wrapping_add(100_003);
            observer.update(counts, 1e-3);
        }
        let turns = observer.position() as f64 / 4_294_967_296.0;
        let expected = 1_000_030_000.0 / (4_095.0 * 66.667);
        assert!((turns - expected).abs() < 1e-5, "{turns} {expected}");
        for _ in 0..10_000 {
            counts = counts.wrapping_sub(100_003);
            observer.update(counts, 1e-3);
        }
        assert_eq!(observer.position(), 0);
    }
}
