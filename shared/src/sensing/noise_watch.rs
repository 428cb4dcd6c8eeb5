//! Finds readings of one sensor that jump back and forth more than any motion of the robot.

use super::trust::{Reason, Trust};
use crate::math::{clamp, max};

/// Minimum duration of such noise from which a sensor is in doubt, and from which it is not
/// trusted, s. The impacts of a robot on stairs are shorter.
const DOUBTED_AFTER: f32 = 0.1;
const LOST_AFTER: f32 = 0.25;
/// The same durations in periods of the sensor. The longer time counts.
const DOUBTED_PERIODS: f32 = 5.0;
const LOST_PERIODS: f32 = 10.0;
/// Time that a reading without a jump takes off, as a fraction of what a reading with a jump adds.
const FORGOTTEN: f32 = 0.5;

/// Monitor of the noise of one sensor.
///
/// A reading jumps back if an axis has moved up and then down, or down and then up, and the product
/// of both changes exceeds the square of a bound. A motion in one direction never counts, however
/// fast it is. So the monitor needs no model of the motion, and one bound serves every rate.
#[derive(Clone, Debug)]
pub struct NoiseWatch {
    /// Minus the square of the smallest jump that counts.
    bound: f32,
    period: f32,
    value: [f32; 3],
    change: [f32; 3],
    /// For how long the readings have jumped, s.
    time: f32,
}

impl NoiseWatch {
    /// Monitor of a sensor that measures `rate` times per second, at least once. Changes below
    /// `jump`, in the unit of its readings, do not count.
    pub fn new(jump: f32, rate: f32) -> Self {
        Self {
            bound: -jump * jump,
            period: 1.0 / max(rate, 1.0),
            value: [0.0; 3],
            change: [0.0; 3],
            time: 0.0,
        }
    }

    /// Takes the next reading, whose `values` are finite.
    pub fn receive(&mut self, values: &[f32]) {
        let mut back = false;
        let before = self.value.iter_mut().zip(&mut self.change);
        for (value, (last, last_change)) in values.iter().zip(before) {
            let change = *value - *last;
            back |= change * *last_change < self.bound;
            (*last, *last_change) = (*value, change);
        }
        let step = if back { 1.0 } else { -FORGOTTEN };
        self.time = clamp(self.time + step * self.period, 0.0, 2.0 * self.lost_after());
    }

    /// How far the sensor is trusted by its noise.
    pub fn trust(&self) -> Trust {
        let doubted = max(DOUBTED_AFTER, DOUBTED_PERIODS * self.period);
        // The comparison is false for NaN.
        if !(self.time < self.lost_after()) {
            Trust::None(Reason::Noisy)
        } else if self.time >= doubted {
            Trust::Degraded(Reason::Noisy)
        } else {
            Trust::Full
        }
    }

    fn lost_after(&self) -> f32 {
        max(LOST_AFTER, LOST_PERIODS * self.period)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times at which a sensor with this rate and `signal` was first doubted and first not trusted
    /// within `seconds`, s.
    fn first(rate: u32, seconds: u32, mut signal: impl FnMut(f32) -> [f32; 3]) -> [Option<f32>; 2] {
        let (mut watch, mut found) = (NoiseWatch::new(1.0, rate as f32), [None; 2]);
        for reading in 1..=rate * seconds {
            let time = reading as f32 / rate as f32;
            watch.receive(&signal(time));
            let found = match watch.trust() {
                Trust::Full => continue,
                Trust::Degraded(_) => &mut found[0],
                Trust::None(_) => &mut found[1],
            };
            found.get_or_insert(time);
        }
        found
    }

    /// Uniform numbers from minus to plus `amplitude` (Knuth's generator of 64 bits).
    fn noise(mut state: u64, amplitude: f32) -> impl FnMut(f32) -> [f32; 3] {
        move |_| {
            core::array::from_fn(|_| {
                state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
                amplitude * ((state >> 32) as i32 as f32) / 2_147_483_648.0
            })
        }
    }

    #[test]
    fn noise_above_the_bound_is_doubted_and_then_not_trusted_at_every_rate() {
        for (rate, doubted, lost) in [
            (1_000, 0.2, 0.5),
            (100, 0.2, 0.5),
            (50, 0.25, 0.5),
            (20, 0.6, 1.2),
            (10, 1.2, 2.4),
        ] {
            for seed in 0..20 {
                let [doubt, loss] = first(rate, 5, noise(seed, 4.0));
                let within = |found: Option<f32>, bound| found.is_some_and(|time| time <= bound);
                assert!(within(doubt, doubted), "{rate} Hz: {doubt:?}");
                assert!(within(loss, lost), "{rate} Hz: {loss:?}");
            }
        }
    }

    #[test]
    fn motions_and_impacts_and_noise_below_the_bound_are_trusted() {
        for rate in [1_000, 100, 50, 20] {
            for seed in 0..20 {
                assert_eq!(first(rate, 20, noise(seed, 0.49)), [None; 2], "{rate} Hz");
            }
            // A swing at 2 Hz, and steps up and down twice per second.
            let swing = |time: f32| [5.0 * libm::sinf(12.6 * time), 0.0, 0.0];
            assert_eq!(first(rate, 20, swing), [None; 2], "{rate} Hz");
            let steps = |time: f32| [0.0, 0.0, 20.0 * libm::floorf(libm::fmodf(2.0 * time, 2.0))];
            assert_eq!(first(rate, 20, steps), [None; 2], "{rate} Hz");
        }
    }

    #[test]
    fn a_sensor_is_trusted_again_when_its_noise_ends() {
        let (mut watch, mut loud) = (NoiseWatch::new(1.0, 100.0), noise(1, 4.0));
        for _ in 0..1_000 {
            watch.receive(&loud(0.0));
        }
        assert_eq!(watch.trust(), Trust::None(Reason::Noisy));
        for _ in 0..100 {
            watch.receive(&[0.0; 3]);
        }
        assert_eq!(watch.trust(), Trust::Full);
    }
}
