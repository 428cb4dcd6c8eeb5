//! Estimates position and velocity of the output shaft from an incremental encoder on the rotor.

use crate::math::Turns;
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
    between: Option<BetweenCounts>,
}

/// What is known of a shaft that turns so slowly that counts come one by one.
#[derive(Clone, Debug, Default)]
struct BetweenCounts {
    /// Time since the last count, s, up to [`LONGEST`].
    waited: f32,
    /// Counts in the tick of the last count, and whether it came slowly.
    last: i32,
    slow: bool,
}

/// Counts that come at longer intervals than this, divided by the bandwidth, are timed. The
/// tracking loop has settled to 5 % by then.
const TIMED: f32 = 4.7;
/// Interval after which the shaft counts as standing, s.
const LONGEST: f32 = 10.0;

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
            between: None,
        }
    }

    /// Times the counts of a shaft that turns slowly: between two counts, the velocity is at most
    /// one count per elapsed time. So it is right down to one count in ten seconds, and has no
    /// pulses. A count forth and back, as noise makes it, is a velocity of 0.
    #[must_use]
    pub fn timing_counts(mut self) -> Self {
        self.between = Some(BetweenCounts::default());
        self
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

        let before = self.velocity;
        let error = self.lag + Turns::from_bits(whole).radians() - self.velocity * period;
        self.lag = error - error * (2.0 * self.bandwidth * period);
        self.velocity += error * (self.bandwidth * self.bandwidth * period);
        if self.between.is_some() {
            self.time_counts(step as i32, period, before);
        }
    }

    /// Replaces the velocity by that of single counts if they come slowly. `before` is the velocity
    /// of the last tick.
    fn time_counts(&mut self, step: i32, period: f32, before: f32) {
        let Some(between) = &mut self.between else {
            return;
        };
        between.waited += period;
        let late = between.waited * self.bandwidth > TIMED;
        if late {
            between.slow = true;
        } else if step != 0 {
            between.slow = false;
        }
        if between.slow {
            let count = Turns::from_bits(self.unit_per_count >> 16).radians();
            let fastest = count / between.waited;
            let goes_on = step.wrapping_mul(between.last) > 0;
            self.velocity = match step {
                _ if between.waited >= LONGEST => 0.0,
                0 => crate::math::limit(before, fastest),
                _ if goes_on => step as f32 * fastest,
                _ => 0.0,
            };
            // The tracking loop continues from here.
            self.lag = 0.0;
        }
        if step != 0 {
            between.waited = 0.0;
            between.last = step;
        } else if between.waited > LONGEST {
            between.waited = LONGEST;
        }
    }

    /// Returns the measured position of the output shaft.
    pub fn position(&self) -> Turns {
        Turns::from_bits(self.measured.whole)
    }

    /// Returns the estimated velocity, rad/s of the output shaft.
    pub fn velocity(&self) -> f32 {
        self.velocity
    }

    /// Defines the present position as `position` of the output shaft.
    pub fn set_position(&mut self, position: Turns) {
        self.measured.whole = position.to_bits();
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

    /// Speed, counts per second, of an encoder with `counts` per turn that reads this position.
    fn settle(observer: &mut Observer, speed: f64, seconds: f64, check: impl Fn(f64)) {
        let ticks = (seconds * 1e3) as i64;
        for tick in 1..=ticks {
            observer.update((speed * tick as f64 * 1e-3).floor() as i32, 1e-3);
            if tick > ticks / 2 {
                check(f64::from(observer.velocity()));
            }
        }
    }

    #[test]
    fn velocity_is_right_from_one_count_per_second_to_top_speed() {
        let radians_per_count = core::f64::consts::TAU / 4_096.0;
        // A tick's error of one millisecond, and the ripple of the tracking loop.
        for (speed, seconds, error) in [
            (1.0, 10.0, 0.002),
            (-1.0, 10.0, 0.002),
            (7.3, 4.0, 0.01),
            (-60.0, 2.0, 0.07),
            (100_000.0, 0.2, 0.001),
            // 6000 rpm.
            (409_600.0, 0.2, 0.001),
            (-409_600.0, 0.2, 0.001),
        ] {
            let mut observer = Observer::new(4_096, 1_000, 600.0, 0).timing_counts();
            let expected = speed * radians_per_count;
            settle(&mut observer, speed, seconds, |velocity| {
                let off = (velocity / expected - 1.0).abs();
                assert!(off <= error, "{speed} counts/s: {velocity}, not {expected}");
            });
        }
    }

    #[test]
    fn between_counts_the_velocity_falls_and_noise_of_a_count_is_none() {
        let count = core::f32::consts::TAU / 4_096.0;
        let mut observer = Observer::new(4_096, 1_000, 600.0, 0).timing_counts();
        settle(&mut observer, 10.0, 1.0, |_| {});
        for waited in 1..=2_000 {
            observer.update(10, 1e-3);
            let bound = count / (waited as f32 * 1e-3) * 1.001;
            let free = waited < 10;
            assert!(free || observer.velocity().abs() <= bound, "{waited} ms");
        }
        for tick in 0..1_000 {
            observer.update(10 + tick / 20 % 2, 1e-3);
            let velocity = observer.velocity();
            // One count that comes after a pause in the same direction is no noise.
            assert!(tick < 40 || velocity.abs() < 1e-6, "{tick}: {velocity}");
        }
    }

    #[test]
    fn a_billion_counts_are_as_many_as_their_closed_form() {
        for (counts, gear, step, updates) in [
            (4_095, 66_667, 997, 1_003_010_u32),
            (1_048_576, 1_000, 1_000, 1_000_000),
            (1_000, 100_003, -499, 2_004_009),
        ] {
            let mut observer = Observer::new(counts, gear, 600.0, i32::MIN).timing_counts();
            let mut reading = i32::MIN;
            for _ in 0..updates {
                reading = reading.wrapping_add(step);
                observer.update(reading, 1e-3);
            }
            let total = i128::from(step) * i128::from(updates);
            assert!(total.unsigned_abs() >= 1_000_000_000);
            // Half a unit of 2^-48 turn is lost per count.
            let exact = (total << 32) * 1_000 / (i128::from(counts) * i128::from(gear));
            let off = i128::from(observer.position().to_bits()) - exact;
            let count = (1_i128 << 32) * 1_000 / (i128::from(counts) * i128::from(gear));
            assert!(
                off.abs() <= count / 2 + 1,
                "{off} of {count} units per count"
            );
        }
    }

    #[test]
    fn a_billion_counts_forth_and_back_end_at_zero() {
        let mut observer = Observer::new(4_095, 66_667, 600.0, i32::MAX - 5);
        let mut counts = i32::MAX - 5;
        for _ in 0..10_000 {
            counts = counts.wrapping_add(100_003);
            observer.update(counts, 1e-3);
        }
        let turns = observer.position().to_bits() as f64 / 4_294_967_296.0;
        let expected = 1_000_030_000.0 / (4_095.0 * 66.667);
        assert!((turns - expected).abs() < 1e-5, "{turns} {expected}");
        for _ in 0..10_000 {
            counts = counts.wrapping_sub(100_003);
            observer.update(counts, 1e-3);
        }
        assert_eq!(observer.position(), Turns::ZERO);
    }
}
