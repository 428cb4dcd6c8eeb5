//! Learns the constant errors of gyroscope and accelerometer while the robot rests.
//!
//! A gyroscope that warms up from -25 to 20 degrees C reads several degrees/s at rest. The robot
//! rests while no track or wheel turns and no mean of inclinometer, accelerometer and gyroscope over
//! [`WINDOW`] differs from that at the beginning of the rest. Then the gyroscope's mean is its
//! constant error. A rotation that the inclinometer does not show can be part of it: that of
//! [`ROTATION`] in the time of the rest. A rotation about the vertical is never shown. So a rest
//! teaches nothing if it changes the error by more than that can have changed since the rest before.

use crate::constants::GRAVITY;
use crate::math::{max, min, sin_cos};
use crate::sensors::BodySensors;
use crate::units::Angle;

/// Largest constant error of an axis of the gyroscope with which the robot is armed, rad/s: 6
/// degrees/s. The data sheet of the LSM6DSV16X has a zero-rate level of 1 degree/s, that of the
/// ICM-20948 one of 5 degrees/s on a board.
pub const RATE_BOUND: f32 = 0.105;
/// Largest change of that error with time, rad/s^2: 0.1 degree/s in a minute. The data sheet of the
/// ICM-20948 has 0.05 degree/s per kelvin, and a board warms up by 2 kelvin a minute.
const DRIFT: f32 = 2.9e-5;
/// Largest constant error of an axis of the accelerometer that is learned, m/s^2: 0.15 g, with
/// which the guard disbelieves the sensors.
const FORCE_BOUND: f32 = 0.15 * GRAVITY;

/// Time over which readings are averaged, s.
const WINDOW: f32 = 0.5;
/// Number of windows after which a rest begins anew, so that a robot that stands for hours learns
/// the drift.
const LONGEST: f32 = 20.0;
/// Largest changes of the means in a rest. Inclination: 0.1 degree, in rad. Specific force: 0.3
/// degree of tilt, in m/s^2. Angular rate: 0.25 degree/s, in rad/s.
const ROTATION: f32 = 1.75e-3;
const FORCE: f32 = 0.05;
const RATE: f32 = 4.4e-3;
/// Time after the start in which the first rest is expected, s.
const PATIENCE: f32 = 10.0;

/// Means of inclination, specific force and angular rate, in this order.
type Means = ([f32; 2], [f32; 3], [f32; 3]);

/// Constant errors of gyroscope and accelerometer, as far as they are known.
#[derive(Clone, Debug, Default)]
pub struct Rest {
    sums: Means,
    counts: [f32; 3],
    /// Time since the start of the window, and since the start of the guard, s.
    time: f32,
    running: f32,
    /// Means of the first window of this rest, and number of its windows.
    first: Option<Means>,
    windows: f32,
    /// Sum of the mean angular rates of this rest, rad/s.
    rates: [f32; 3],
    rate: [f32; 3],
    force: [f32; 3],
    /// Uncertainty of the rate when it was learned, rad/s, and the time since, s.
    uncertainty: Option<f32>,
    age: f32,
}

impl Rest {
    /// Takes readings in body axes, with the constant errors.
    #[inline]
    pub fn receive(&mut self, sensors: &BodySensors) {
        let fresh = sensors.fresh;
        let [inclinations, forces, rates] = &mut self.counts;
        sum(
            &mut self.sums.0,
            inclinations,
            sensors.inclination,
            fresh.inclinometer,
        );
        sum(
            &mut self.sums.1,
            forces,
            sensors.specific_force,
            fresh.accelerometer,
        );
        sum(
            &mut self.sums.2,
            rates,
            sensors.angular_rate,
            fresh.gyroscope,
        );
    }

    /// Learns the errors, once per evaluation, `period` s after the previous one. `rests`: no
    /// track or wheel turns, and every sensor is believed by itself. Returns the inclination, rad, when the errors
    /// are learned for the first time.
    pub fn advance(&mut self, rests: bool, period: f32) -> Option<[f32; 2]> {
        self.age += period;
        self.running = min(self.running + period, PATIENCE);
        self.time += period;
        if rests && self.time < WINDOW {
            return None;
        }
        let means = self.take_means().filter(|_| rests);
        let (Some(first), Some(means)) = (self.first, means) else {
            self.begin(means);
            return None;
        };
        if !steady(&first, &means) || self.windows >= LONGEST {
            self.begin(Some(means));
            return None;
        }
        self.windows += 1.0;
        add(&mut self.rates, means.2);
        self.learn(&means)
    }

    fn begin(&mut self, means: Option<Means>) {
        self.first = means;
        self.windows = 1.0;
        self.rates = means.map_or([0.0; 3], |(_, _, rate)| rate);
    }

    fn learn(&mut self, (inclination, force, _): &Means) -> Option<[f32; 2]> {
        let uncertainty = ROTATION / (WINDOW * (self.windows - 1.0));
        let known = self.uncertainty.is_some();
        let bound = self.rate_uncertainty();
        let rate = self.rates.map(|sum| sum / self.windows);
        let mut pairs = rate.iter().zip(self.rate);
        let agrees = pairs.all(|(now, before)| (now - before).abs() <= bound + uncertainty);
        if known && !(agrees && uncertainty < bound) {
            return None;
        }
        (self.rate, self.uncertainty, self.age) = (rate, Some(uncertainty), 0.0);
        if known {
            return None;
        }
        let [pitch, roll] = inclination.map(|angle| sin_cos(Angle::from_radians(angle)));
        let up = [pitch.0 * roll.1, roll.0, pitch.1 * roll.1];
        let error: [f32; 3] = core::array::from_fn(|axis| force[axis] - up[axis] * GRAVITY);
        // A larger difference is a fault, which the comparison of the sensors finds.
        if error.iter().all(|error| error.abs() <= FORCE_BOUND) {
            self.force = error;
        }
        Some(*inclination)
    }

    fn take_means(&mut self) -> Option<Means> {
        let (inclination, force, rate) = core::mem::take(&mut self.sums);
        let [inclinations, forces, rates] = core::mem::take(&mut self.counts);
        self.time = 0.0;
        (inclinations > 0.0 && forces > 0.0 && rates > 0.0).then(|| {
            (
                inclination.map(|sum| sum / inclinations),
                force.map(|sum| sum / forces),
                rate.map(|sum| sum / rates),
            )
        })
    }

    /// Constant error of the gyroscope in body axes, rad/s.
    pub fn rate(&self) -> [f32; 3] {
        self.rate
    }

    /// Constant error of the accelerometer in body axes, m/s^2.
    pub fn force(&self) -> [f32; 3] {
        self.force
    }

    /// Largest rate by which the gyroscope may be wrong without its constant error, rad/s. Before
    /// that is learned, which the robot is not armed without, it is 0.
    pub fn rate_uncertainty(&self) -> f32 {
        self.uncertainty
            .map_or(0.0, |learned| learned + DRIFT * self.age)
    }

    /// Largest constant error of an axis of the gyroscope, rad/s; 0 before it is learned.
    pub fn largest_rate(&self) -> f32 {
        let [x, y, z] = self.rate.map(f32::abs);
        max(x, max(y, z))
    }

    /// Whether the errors are not known yet, soon after the start.
    pub fn expected(&self) -> bool {
        self.uncertainty.is_none() && self.running < PATIENCE
    }

    /// Whether the errors are not known although the guard has run for long.
    pub fn missed(&self) -> bool {
        self.uncertainty.is_none() && !self.expected()
    }
}

#[inline]
fn sum<const N: usize>(sums: &mut [f32; N], count: &mut f32, values: [f32; N], fresh: bool) {
    if fresh {
        add(sums, values);
        *count += 1.0;
    }
}

fn add<const N: usize>(sums: &mut [f32; N], values: [f32; N]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += value;
    }
}

/// Whether no mean has changed by more than its bound. The comparisons are false for NaN.
fn steady(first: &Means, means: &Means) -> bool {
    let within = |before: &[f32], now: &[f32], bound: f32| {
        let mut pairs = before.iter().zip(now);
        pairs.all(|(before, now)| (now - before).abs() < bound)
    };
    within(&first.0, &means.0, ROTATION)
        && within(&first.1, &means.1, FORCE)
        && within(&first.2, &means.2, RATE)
}
