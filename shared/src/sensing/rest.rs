//! Learns the constant errors of gyroscope and accelerometer while the robot rests.
//!
//! A gyroscope that warms up from -25 to 20 degrees C reads several degrees/s at rest. The robot
//! rests while no track or wheel turns and no mean of inclinometer, accelerometer and gyroscope
//! over [`WINDOW`] differs from that at the beginning of the rest, but for the noise that the
//! readings show. Then the gyroscope's mean is its constant error. A rotation can be part of it:
//! what the inclinometer shows from the first window to the last one and what its noise hides, in
//! the time of the rest.
//!
//! The inclinometer does not show a rotation about the vertical. So a rest is a contradiction if it
//! changes the error by more than that can have changed since the rest before. While it is, the
//! margins allow for both values. The newer value counts once it has lasted for [`LONGEST`]
//! windows.

use crate::constants::GRAVITY;
use crate::math::{max, sin_cos, sqrt};
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

/// Time over which readings are averaged, s. Two of them are shorter than the time in which the
/// attitude settles.
const WINDOW: f32 = 0.2;
/// Number of windows after which a rest begins anew, so that a robot that stands for hours learns
/// the drift.
const LONGEST: f32 = 50.0;
/// Largest changes of the means in a rest. Inclination: 0.1 degree, in rad. Specific force: 0.3
/// degree of tilt, in m/s^2. Angular rate: 0.25 degree/s, in rad/s.
const ROTATION: f32 = 1.75e-3;
const FORCE: f32 = 0.05;
const RATE: f32 = 4.4e-3;
/// Smallest uncertainty, rad/s: 0.05 degree/s, for resolution and for the influence of gravity on a
/// gyroscope.
const RESOLUTION: f32 = 8.7e-4;
/// Uncertainty with which the robot is armed at once, rad/s: 0.25 degree/s, which turns the
/// attitude by half a degree.
const ENOUGH: f32 = 4.4e-3;
/// Time for which the start waits for that, s. Then an error that is not learned counts as the
/// worst one.
const LONGEST_WAIT: f32 = 3.0;
/// Standard deviations of the noise that are allowed on top.
const SIGMAS: f32 = 3.0;

/// Readings of one sensor in a window.
#[derive(Clone, Debug)]
struct Readings<const N: usize> {
    count: f32,
    sum: [f32; N],
    /// Sum of the readings, each times its number less a half.
    ramp: [f32; N],
    newest: [f32; N],
    /// Sum of the squares of the differences of successive readings.
    squares: [f32; N],
}

/// Mean of such readings, the mean of the readings with weights that rise from 0 to 1 over the
/// window, and the variance of the mean by their noise.
#[derive(Clone, Copy, Debug)]
struct Mean<const N: usize> {
    value: [f32; N],
    rising: [f32; N],
    variance: [f32; N],
}

/// Means of inclination, specific force and angular rate.
#[derive(Clone, Copy, Debug)]
struct Means {
    inclination: Mean<2>,
    force: Mean<3>,
    rate: Mean<3>,
}

/// Constant errors of gyroscope and accelerometer, as far as they are known.
#[derive(Clone, Debug, Default)]
pub struct Rest {
    inclinations: Readings<2>,
    forces: Readings<3>,
    rates: Readings<3>,
    /// Time since the start of the window, s.
    time: f32,
    /// Means of the first window of this rest, and number of its windows.
    first: Option<Means>,
    windows: f32,
    /// Weighted sum of the mean angular rates of this rest without its newest window, rad/s.
    rate_sum: [f32; 3],
    learned: bool,
    rate: [f32; 3],
    force: [f32; 3],
    /// Uncertainty of the rate when it was learned, rad/s, and the time since, s.
    uncertainty: f32,
    age: f32,
    /// Uncertainty of the rate, rad/s, since a later rest has contradicted it; else 0.
    disputed: f32,
    /// Time for which the start has waited, s.
    waited: f32,
}

impl<const N: usize> Default for Readings<N> {
    fn default() -> Self {
        Self {
            count: 0.0,
            sum: [0.0; N],
            ramp: [0.0; N],
            newest: [0.0; N],
            squares: [0.0; N],
        }
    }
}

impl<const N: usize> Readings<N> {
    #[inline]
    fn receive(&mut self, values: [f32; N], fresh: bool) {
        if !fresh {
            return;
        }
        for (axis, value) in values.into_iter().enumerate() {
            let change = value - self.newest[axis];
            if self.count > 0.0 {
                self.squares[axis] += change * change;
            }
            self.newest[axis] = value;
            self.sum[axis] += value;
            self.ramp[axis] += (self.count + 0.5) * value;
        }
        self.count += 1.0;
    }

    /// Begins a new window. Returns the mean of the last one if it had two readings.
    fn take(&mut self) -> Option<Mean<N>> {
        let Self {
            count,
            sum,
            ramp,
            squares,
            ..
        } = core::mem::take(self);
        // Half the mean square of the differences is the variance of a reading.
        let per_mean = 0.5 / ((count - 1.0) * count);
        (count > 1.0).then(|| Mean {
            value: sum.map(|sum| sum / count),
            rising: ramp.map(|ramp| ramp / (count * count)),
            variance: squares.map(|squares| squares * per_mean),
        })
    }
}

impl<const N: usize> Mean<N> {
    /// Whether no axis has changed by more than `bound` and the noise. False for NaN.
    fn steady(&self, now: &Self, bound: f32) -> bool {
        (0..N).all(|axis| {
            let excess = max((now.value[axis] - self.value[axis]).abs() - bound, 0.0);
            let variance = self.variance[axis] + now.variance[axis];
            excess * excess <= SIGMAS * SIGMAS * variance
        })
    }

    /// Largest change of an axis, with its error by the noise of both means.
    fn change(&self, now: &Self) -> f32 {
        (0..N).fold(0.0, |most, axis| {
            let change = (now.value[axis] - self.value[axis]).abs();
            let variance = self.variance[axis] + now.variance[axis];
            max(most, change + SIGMAS * sqrt(variance))
        })
    }

    /// Largest error of the mean by its noise.
    fn noise(&self) -> f32 {
        SIGMAS * sqrt(self.variance.into_iter().fold(0.0, max))
    }
}

impl Rest {
    /// Takes readings in body axes, with the constant errors.
    #[inline]
    pub fn receive(&mut self, sensors: &BodySensors) {
        let fresh = sensors.fresh;
        self.inclinations
            .receive(sensors.inclination, fresh.inclinometer);
        self.forces
            .receive(sensors.specific_force, fresh.accelerometer);
        self.rates.receive(sensors.angular_rate, fresh.gyroscope);
    }

    /// Learns the errors, once per evaluation, `period` s after the previous one. `rests`: no track
    /// or wheel turns, and every sensor is believed by itself. Returns the inclination, rad, when
    /// the errors are learned for the first time.
    pub fn advance(&mut self, rests: bool, period: f32) -> Option<[f32; 2]> {
        self.age += period;
        self.time += period;
        if rests && self.time < WINDOW {
            return None;
        }
        let means = self.take_means().filter(|_| rests);
        let (Some(first), Some(means)) = (self.first, means) else {
            self.begin(means);
            return None;
        };
        if !first.steady(&means) || self.windows >= LONGEST {
            self.begin(Some(means));
            return None;
        }
        self.windows += 1.0;
        let level = self.learn(&first, &means);
        for (sum, value) in self.rate_sum.iter_mut().zip(means.rate.value) {
            *sum += value;
        }
        level
    }

    fn begin(&mut self, means: Option<Means>) {
        self.first = means;
        self.windows = 1.0;
        self.rate_sum = means.map_or([0.0; 3], |means| means.rate.rising);
    }

    /// Learns from the first and the newest window of a rest. Returns as [`Self::advance`].
    fn learn(&mut self, first: &Means, newest: &Means) -> Option<[f32; 2]> {
        let (rate, uncertainty) = self.estimate(first, newest);
        let begins = !self.learned;
        if !self.accepts(rate, uncertainty) {
            return None;
        }
        (self.rate, self.uncertainty, self.age) = (rate, uncertainty, 0.0);
        (self.disputed, self.learned) = (0.0, true);
        begins.then(|| {
            self.learn_force(newest);
            newest.inclination.value
        })
    }

    /// Returns the gyroscope's constant error by this rest, and its uncertainty, rad/s.
    fn estimate(&self, first: &Means, newest: &Means) -> ([f32; 3], f32) {
        // Weights that rise over the first window and fall over the newest one: so weighted, the
        // true rate is the change of the mean inclination from the first to the newest window.
        let intervals = self.windows - 1.0;
        let rate = core::array::from_fn(|axis| {
            let falling = newest.rate.value[axis] - newest.rate.rising[axis];
            (self.rate_sum[axis] + falling) / intervals
        });
        let rotation = first.inclination.change(&newest.inclination);
        let noise = max(first.rate.noise(), newest.rate.noise());
        let uncertainty = rotation / (WINDOW * intervals) + noise / sqrt(intervals);
        (rate, max(uncertainty, RESOLUTION))
    }

    /// Whether this error replaces the one that is known. A contradiction does not at first.
    fn accepts(&mut self, rate: [f32; 3], uncertainty: f32) -> bool {
        if !self.learned {
            return uncertainty < RATE_BOUND;
        }
        let before = self.uncertainty + DRIFT * self.age;
        let pairs = rate.iter().zip(self.rate);
        let difference = pairs.fold(0.0, |most, (now, before)| max(most, (now - before).abs()));
        if difference <= before + uncertainty {
            self.disputed = 0.0;
            return uncertainty < before;
        }
        self.disputed = difference + uncertainty;
        self.windows >= LONGEST
    }

    fn learn_force(&mut self, newest: &Means) {
        let inclination = newest.inclination.value;
        let [pitch, roll] = inclination.map(|angle| sin_cos(Angle::from_radians(angle)));
        let up = [pitch.0 * roll.1, roll.0, pitch.1 * roll.1];
        let force = newest.force.value;
        let error: [f32; 3] = core::array::from_fn(|axis| force[axis] - up[axis] * GRAVITY);
        // A larger difference is a fault, which the comparison of the sensors finds.
        if error.iter().all(|error| error.abs() <= FORCE_BOUND) {
            self.force = error;
        }
    }

    fn take_means(&mut self) -> Option<Means> {
        self.time = 0.0;
        let inclination = self.inclinations.take();
        let (force, rate) = (self.forces.take(), self.rates.take());
        Some(Means {
            inclination: inclination?,
            force: force?,
            rate: rate?,
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

    /// Largest rate by which the gyroscope may be wrong without its constant error, rad/s. It is 0
    /// until the error is learned or [`Self::wait`] gives up.
    pub fn rate_uncertainty(&self) -> f32 {
        if self.known() {
            max(self.uncertainty + DRIFT * self.age, self.disputed)
        } else {
            0.0
        }
    }

    /// Largest constant error of an axis of the gyroscope, rad/s; 0 before it is learned.
    pub fn largest_rate(&self) -> f32 {
        let [x, y, z] = self.rate.map(f32::abs);
        max(x, max(y, z))
    }

    /// Whether the error is learned, or counts as the worst one.
    pub fn known(&self) -> bool {
        self.uncertainty > 0.0
    }

    /// Notes for `period` s whether the start waits for a rest (`waits`). Returns whether it waits
    /// on: until the errors are known well enough, and no longer than [`LONGEST_WAIT`].
    pub fn wait(&mut self, waits: bool, period: f32) -> bool {
        self.waited = if waits { self.waited + period } else { 0.0 };
        let in_time = self.waited < LONGEST_WAIT;
        if !(in_time || self.learned) {
            (self.uncertainty, self.age) = (RATE_BOUND, 0.0);
        }
        in_time && !(self.learned && self.rate_uncertainty() <= ENOUGH)
    }
}

impl Means {
    /// Whether no mean has changed by more than its bound and the noise.
    fn steady(&self, now: &Self) -> bool {
        self.inclination.steady(&now.inclination, ROTATION)
            && self.force.steady(&now.force, FORCE)
            && self.rate.steady(&now.rate, RATE)
    }
}
