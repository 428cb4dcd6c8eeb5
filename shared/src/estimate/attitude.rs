//! Estimates pitch, roll and heading from the gyroscope, the inclinometer and the compass.
//!
//! The integrated rates drift, every acceleration tilts the inclinometer's reading, and the compass
//! is slow. A complementary filter combines the three. The speed of the drives says which
//! accelerations are the robot's own.

use crate::constants::GRAVITY;
use crate::math::{atan2, limit, max, min, sin_cos, sqrt};
use crate::sensors::{BodySensors, Fresh};
use crate::units::Angle;

/// Time constant with which the inclinometer corrects pitch and roll, s. In this time, a constant
/// error of the gyroscope of 0.1 degree/s turns the estimate by 0.2 degree.
const LEVEL_TIME: f32 = 2.0;
/// Time constant over which the inclinometer's readings are averaged, as a fraction of the one
/// above: 0.3 s, longer than an impact.
const AVERAGED: f32 = 0.15;
/// Time after the first inclination in which the inclinometer corrects faster, s, and its time
/// constant then, as a fraction of the time since the first inclination. With this one, the share
/// of a wrong reading falls with the square of the time.
const SETTLING: f32 = 1.0;
const GROWTH: f32 = 0.5;
/// Time after the first inclination from which the estimate's changes are motions of the robot, s.
const SETTLED: f32 = 0.25;
/// Time after the first inclination from which the robot may be armed, s. Brakes that engage, or
/// drives that stop a robot that rolls, make it rock for some 0.2 s.
const ARMABLE: f32 = 0.5;
/// Time for which the drives have explained the whole reading, s, from which the estimate may err
/// by all that they explain.
const DRAWN: f32 = 1.0;
/// Time constant with which the compass corrects the heading, s.
const HEADING_TIME: f32 = 2.0;
/// Longest time for which the estimate goes on with one reading of the gyroscope, s: five periods
/// at 20 Hz. Long before, the guard stops the robot.
const HOLD_LIMIT: f32 = 0.25;
/// Time after the first inclination in which the first compass heading sets the heading, s: longer
/// than the period of a compass with 5 Hz, shorter than a robot needs to start to drive.
const HEADING_WAIT: f32 = 0.25;
/// Longest time for which one reading of the inclinometer corrects, s.
const LONGEST_CORRECTION: f32 = 0.5;

/// Smallest cosine of the roll that the yaw rate is divided by: that of 78 degrees. At 90 degrees,
/// no pitch is defined.
const LEAST_COSINE: f32 = 0.2;

/// Complementary filter for pitch, roll and heading.
///
/// The angles are q6, q5 and q4 of Paillat et al.: roll about the heading, then pitch about the
/// robot's transverse axis. Nose up, left side up and counter-clockwise are positive.
///
/// The filter averages the difference of inclinometer and estimate, not the inclinometer alone. So
/// it forgets impacts and noise, and does not pull the estimate back during a fast swing.
///
/// An inclinometer measures the specific force. An acceleration `a` along a body without roll turns
/// its pitch by `a cos(pitch) / g`, and a turn to the left turns its roll by the speed times the
/// yaw rate, over `g`. The filter subtracts both with the speed of the drives ([`Self::travel`]),
/// but no more than the inclinometer shows: tracks or wheels that spin do not accelerate the body.
/// While the drives explain the whole reading, the gyroscope alone carries the estimate
/// ([`Self::drift`]). So in a turn the estimate errs by what the gyroscope drifts meanwhile and by
/// what noise adds, but never by more than this acceleration over `g`, whether the tracks slip or
/// not.
/// It takes every reading, however far its magnitude is from `g`: the mean acceleration of a robot
/// that is stopped and set in motion again is zero, but not if the readings of the stop are left
/// out.
///
/// The first inclination may be wrong by any angle, because nothing averages it. So for a time
/// [`SETTLING`], both time constants are shorter: they grow with the time since then. The same
/// holds after an outage of the inclinometer for [`LONGEST_CORRECTION`] or of the gyroscope for
/// [`HOLD_LIMIT`].
///
/// Each sensor measures at its own rate. Between two readings of the gyroscope the estimate goes on
/// with the last one, for at most [`HOLD_LIMIT`]. When the next one comes, the time between them
/// counts with their mean.
#[derive(Clone, Debug, Default)]
pub struct Attitude {
    tilt: Option<[Angle; 2]>,
    /// Inclinometer minus estimate, and what the acceleration of the drives explains of it, both
    /// low-pass filtered, rad; and what is left unexplained.
    measured: [f32; 2],
    explained: [f32; 2],
    contradiction: [f32; 2],
    /// Time for which the drives have explained the whole reading, s, and the largest angle that
    /// they have explained meanwhile, rad.
    unlevelled: f32,
    hidden: f32,
    pitch_rate: f32,
    heading: Angle,
    /// Time from the first inclination, or from the end of an outage, to the newest one, s, up to
    /// [`SETTLING`], and whether a compass heading has come.
    running: f32,
    headed: bool,
    /// Newest angular rate in body axes, rad/s, and for how long the estimate has used it, s.
    angular_rate: [f32; 3],
    held: f32,
    /// Time since the newest inclination, s.
    levelled: f32,
    /// Distance by the encoders, um; speed along the body, m/s, now and at the newest inclination.
    odometry_um: Option<i32>,
    speed: f32,
    levelled_speed: f32,
}

impl Attitude {
    /// Advances the estimate by one control period of `period` s. It uses those of the readings
    /// that are fresh and finite. Before the first inclination it returns false and changes
    /// nothing.
    pub fn update(&mut self, sensors: &BodySensors, period: f32) -> bool {
        let Fresh {
            inclinometer,
            gyroscope,
            ..
        } = sensors.fresh;
        let finite = |values: &[f32]| values.iter().all(|value| value.is_finite());
        let level = (inclinometer && finite(&sensors.inclination))
            .then(|| sensors.inclination.map(Angle::from_radians));
        let Some([pitch, roll]) = self.tilt.or(level) else {
            return false;
        };
        let rate = (gyroscope && finite(&sensors.angular_rate)).then_some(sensors.angular_rate);
        let [rate_x, rate_y, rate_z] = self.mean_rate(rate, period);
        let (sine, cosine) = sin_cos(pitch);
        let (roll_sine, roll_cosine) = sin_cos(roll);
        let per_cosine = 1.0 / max(roll_cosine, LEAST_COSINE);
        let yaw_rate = (rate_x * sine + rate_z * cosine) * per_cosine;
        let rates = [
            yaw_rate * roll_sine - rate_y,
            rate_x * cosine - rate_z * sine,
        ];
        let [x, y, z] = self.angular_rate;
        self.pitch_rate = (x * sine + z * cosine) * per_cosine * roll_sine - y;

        self.levelled = min(self.levelled + period, LONGEST_CORRECTION);
        let mut step = rates.map(|rate| rate * period);
        if let Some(level) = level {
            // The first reading says nothing about accelerations, and so does the first one after
            // an outage.
            if self.tilt.is_none() || self.levelled >= LONGEST_CORRECTION {
                (self.running, self.levelled_speed) = (0.0, self.speed);
            } else {
                self.running = min(self.running + self.levelled, SETTLING);
            }
            let time = if self.running >= SETTLING {
                LEVEL_TIME
            } else {
                max(GROWTH * self.running, self.levelled)
            };
            let share = ratio(self.levelled, AVERAGED * time + self.levelled);
            let correction = ratio(self.levelled, time);
            let forward = ratio(self.speed - self.levelled_speed, self.levelled);
            let own = [forward * cosine, self.speed * z * roll_cosine];
            let mut all_explained = false;
            for (axis, tilt) in [pitch, roll].into_iter().enumerate() {
                let explained = limit(own[axis], GRAVITY) / GRAVITY;
                self.explained[axis] += (explained - self.explained[axis]) * share;
                let measured = (level[axis] - tilt).radians();
                self.measured[axis] += (measured - self.measured[axis]) * share;
                self.contradiction[axis] = unexplained(self.measured[axis], self.explained[axis]);
                if !(self.contradiction[axis].abs() > 0.0) {
                    all_explained = true;
                    self.hidden = max(self.hidden, self.explained[axis].abs());
                }
                step[axis] += self.contradiction[axis] * correction;
            }
            if all_explained {
                self.unlevelled += self.levelled;
            } else {
                self.unlevelled -= self.unlevelled * correction;
                self.hidden -= self.hidden * correction;
            }
            (self.levelled, self.levelled_speed) = (0.0, self.speed);
        }
        let tilt = [pitch, roll];
        let tilt = core::array::from_fn(|axis| tilt[axis] + Angle::from_radians(step[axis]));
        self.tilt = Some(tilt);
        self.heading += Angle::from_radians(yaw_rate * period);
        true
    }

    /// Sets the tilt of a robot at rest, rad: pitch and roll, as the inclinometer shows them.
    pub fn rest(&mut self, inclination: [f32; 2]) {
        self.tilt = Some(inclination.map(Angle::from_radians));
        (self.measured, self.contradiction) = ([0.0; 2], [0.0; 2]);
        (self.unlevelled, self.hidden) = (0.0, 0.0);
    }

    /// Takes the distance that the robot has travelled by its drives, forward positive, um (it
    /// wraps), `period` s after the previous call. The speed is wrong while the tracks slip or a
    /// posture motion turns wheels.
    pub fn travel(&mut self, odometry_um: i32, period: f32) {
        let before = self.odometry_um.replace(odometry_um);
        let distance = odometry_um.wrapping_sub(before.unwrap_or(odometry_um));
        self.speed = ratio(distance as f32 * 1e-6, period);
    }

    /// Returns the angular rate that counts for this period: the last one that came, plus what the
    /// estimate missed since the one before, if one comes now.
    fn mean_rate(&mut self, newest: Option<[f32; 3]>, period: f32) -> [f32; 3] {
        let Some(newest) = newest else {
            if self.held >= HOLD_LIMIT {
                return [0.0; 3];
            }
            self.held += period;
            return self.angular_rate;
        };
        let before = core::mem::replace(&mut self.angular_rate, newest);
        let held = core::mem::take(&mut self.held);
        if held >= HOLD_LIMIT {
            // Nobody knows how the robot has turned meanwhile.
            self.running = 0.0;
        }
        if !(held > 0.0) {
            return newest;
        }
        let missed = 0.5 * ratio(held, period);
        core::array::from_fn(|axis| newest[axis] + (newest[axis] - before[axis]) * missed)
    }

    /// Corrects the heading with a compass heading that counts for `period` s. Call it after
    /// [`Self::update`].
    ///
    /// The first compass heading becomes the heading if it comes within [`HEADING_WAIT`] of the
    /// first inclination. Later ones change it by at most 0.25 rad/s, so that a late or wrong
    /// compass cannot make a robot that holds its heading turn on the spot.
    pub fn correct_heading(&mut self, compass: Angle, period: f32) {
        let error = compass - self.heading;
        let first = !self.headed && self.running < HEADING_WAIT;
        self.headed = true;
        self.heading += if first {
            error
        } else {
            Angle::from_radians(limit(error.radians(), 0.5) / HEADING_TIME * period)
        };
    }

    /// Whether readings were received at least once.
    pub fn known(&self) -> bool {
        self.tilt.is_some()
    }

    /// Whether the estimate has followed the first readings for some time. Before, its changes may
    /// be corrections instead of a motion of the robot.
    pub fn settled(&self) -> bool {
        self.running >= SETTLED
    }

    /// Whether the first readings still change the estimate by more than an armed robot bears.
    pub fn settling(&self) -> bool {
        self.known() && self.running < ARMABLE
    }

    /// Pitch, nose up positive.
    pub fn pitch(&self) -> Angle {
        self.tilt.map_or(Angle::ZERO, |[pitch, _]| pitch)
    }

    /// Roll, left side up positive.
    pub fn roll(&self) -> Angle {
        self.tilt.map_or(Angle::ZERO, |[_, roll]| roll)
    }

    /// Pitch rate, rad/s.
    pub fn pitch_rate(&self) -> f32 {
        self.pitch_rate
    }

    /// Largest error of the estimate, rad, if the gyroscope's rate is wrong by `rate`, rad/s, on
    /// every axis. Noise, too, draws the estimate toward what the drives explain, in some seconds.
    pub fn drift(&self, rate: f32) -> f32 {
        let (sine, cosine) = sin_cos(self.pitch());
        let (roll_sine, roll_cosine) = sin_cos(self.roll());
        let across = sine.abs() + cosine.abs();
        let slope = roll_sine.abs() / max(roll_cosine, LEAST_COSINE);
        let rate = rate * max(across, 1.0 + across * slope);
        let turned = if self.unlevelled > DRAWN {
            self.hidden
        } else {
            min(rate * self.unlevelled, self.hidden)
        };
        rate * LEVEL_TIME + turned
    }

    /// Inclinometer minus estimate without what the drives explain, averaged over 0.3 s: pitch and
    /// roll, rad.
    pub fn contradiction(&self) -> [f32; 2] {
        self.contradiction
    }

    /// Heading, counter-clockwise seen from above: from true north with a compass, otherwise from
    /// the heading at the start.
    pub fn heading(&self) -> Angle {
        self.heading
    }

    /// Transformation from body axes to level axes, for use with many vectors.
    #[inline]
    pub fn level_axes(&self) -> LevelAxes {
        LevelAxes {
            pitch: sin_cos(self.pitch()),
            roll: sin_cos(self.roll()),
        }
    }

    /// Transforms a vector from body axes to level axes: x along the heading, z up.
    pub fn level(&self, vector: [f32; 3]) -> [f32; 3] {
        self.level_axes().of(vector)
    }
}

/// Returns `value / time`; 0 if there is no time.
fn ratio(value: f32, time: f32) -> f32 {
    if time > 0.0 { value / time } else { 0.0 }
}

/// Returns the part of `measured` that `explained` does not explain: `measured` minus `explained`,
/// which is first limited to what is between 0 and `measured`.
fn unexplained(measured: f32, explained: f32) -> f32 {
    if !(measured * explained > 0.0) {
        measured
    } else if explained.abs() < measured.abs() {
        measured - explained
    } else {
        0.0
    }
}

/// Transformation from body axes to level axes: sines and cosines of pitch and roll.
#[derive(Clone, Copy, Debug)]
pub struct LevelAxes {
    pitch: (f32, f32),
    roll: (f32, f32),
}

impl LevelAxes {
    /// Sine and cosine of the pitch.
    #[inline]
    pub fn pitch(&self) -> (f32, f32) {
        self.pitch
    }

    /// Direction up in body axes.
    #[inline]
    pub fn up(&self) -> [f32; 3] {
        let ((pitch_sine, pitch_cosine), (roll_sine, roll_cosine)) = (self.pitch, self.roll);
        [
            pitch_sine * roll_cosine,
            roll_sine,
            pitch_cosine * roll_cosine,
        ]
    }

    /// Axes of a body that is pitched up further, by an angle with this sine and cosine.
    #[must_use]
    pub fn pitched(self, (sine, cosine): (f32, f32)) -> Self {
        let (pitch_sine, pitch_cosine) = self.pitch;
        Self {
            pitch: (
                pitch_sine * cosine + pitch_cosine * sine,
                pitch_cosine * cosine - pitch_sine * sine,
            ),
            ..self
        }
    }

    /// Transforms a vector from body axes to level axes: x along the heading, z up.
    #[inline]
    pub fn of(&self, vector: [f32; 3]) -> [f32; 3] {
        self.lowest(vector, 0.0)
    }

    /// Lowest point, in level axes, of a disc of `radius` around `centre` whose axle is transverse
    /// to the body.
    #[inline]
    pub fn lowest(&self, centre: [f32; 3], radius: f32) -> [f32; 3] {
        let ((pitch_sine, pitch_cosine), (roll_sine, roll_cosine)) = (self.pitch, self.roll);
        let [x, y, z] = centre;
        let forward = x * pitch_cosine - z * pitch_sine;
        // The pitch turns the disc about its own axle; the roll tilts the disc.
        let up = x * pitch_sine + z * pitch_cosine - radius;
        [
            forward,
            y * roll_cosine - up * roll_sine,
            y * roll_sine + up * roll_cosine,
        ]
    }
}

/// Returns pitch and roll, rad, at which `up`, a vector of any length in body axes, points up. It
/// is the inverse of [`LevelAxes::up`].
#[inline]
pub fn pitch_and_roll([x, y, z]: [f32; 3]) -> [f32; 2] {
    [atan2(x, z), atan2(y, sqrt(x * x + z * z))]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Simulates a swing about the transverse axis with an ideal gyroscope and an inclinometer 0.3
    /// m above the axis: the specific force along x is `g sin(pitch) - h pitch''`. Before, the
    /// robot stands for 1.5 s.
    #[test]
    fn follows_a_fast_swing_although_it_accelerates_the_inclinometer() {
        let (mut attitude, mut worst) = (Attitude::default(), 0.0_f64);
        for step in 0..9_500 {
            let time = f64::from(step) * 1e-3 - 1.5;
            let swings = if time < 0.0 { 0.0 } else { 0.4 };
            let (sine, cosine) = (libm::sin(3.0 * time), libm::cos(3.0 * time));
            let (pitch, rate) = (swings * sine, 3.0 * swings * cosine);
            let forward = 9.81 * libm::sin(pitch) + 0.3 * 9.0 * swings * sine;
            let up = 9.81 * libm::cos(pitch) - 0.3 * rate * rate;
            let sensors = BodySensors {
                inclination: [libm::atan2(forward, up) as f32, 0.0],
                angular_rate: [0.0, -rate as f32, 0.0],
                ..BodySensors::default()
            };
            attitude.update(&sensors, 1e-3);
            let error = (f64::from(attitude.pitch().radians()) - pitch).abs();
            worst = if error > worst { error } else { worst };
        }
        assert!(worst < 0.03, "worst error {worst} rad");
    }

    /// Simulates the same swing with readings of inclinometer and gyroscope at these rates.
    #[test]
    fn follows_a_fast_swing_at_50_hz() {
        for (rate, allowed) in [(200, 0.011), (100, 0.012), (50, 0.02), (20, 0.08)] {
            let (mut attitude, mut worst) = (Attitude::default(), 0.0_f64);
            for step in 0..8_000 {
                let time = f64::from(step) * 1e-3;
                let (pitch, turning) = (0.4 * libm::sin(3.0 * time), 1.2 * libm::cos(3.0 * time));
                let new = step % (1_000 / rate) == 0;
                let sensors = BodySensors {
                    inclination: [pitch as f32, 0.0],
                    angular_rate: [0.0, -turning as f32, 0.0],
                    fresh: if new { Fresh::ALL } else { Fresh::NONE },
                    ..BodySensors::default()
                };
                attitude.update(&sensors, 1e-3);
                let error = (f64::from(attitude.pitch().radians()) - pitch).abs();
                worst = if error > worst { error } else { worst };
            }
            assert!(worst < allowed, "{rate} Hz: worst error {worst} rad");
        }
    }

    /// A gyroscope with 50 Hz that falls silent in the middle of a turn.
    #[test]
    fn a_silent_gyroscope_does_not_turn_the_estimate_for_long() {
        let mut attitude = Attitude::default();
        let turning = BodySensors {
            angular_rate: [0.0, -1.0, 0.0],
            ..BodySensors::default()
        };
        attitude.update(&turning, 1e-3);
        let silent = BodySensors {
            fresh: Fresh::NONE,
            ..turning
        };
        for _ in 0..5_000 {
            attitude.update(&silent, 1e-3);
        }
        let turned = attitude.pitch().radians();
        assert!((turned - 0.25).abs() < 2e-3, "{turned}");
    }

    /// 0.5 g along the body turns the inclinometer's reading by 27 degrees for half a second, and a
    /// track that hits the ground shakes it by 1 g for longer. Before, the robot stands for 2 s.
    #[test]
    fn accelerations_of_the_inclinometer_turn_the_estimate_little() {
        let after = |seconds: f32, acceleration: &dyn Fn(u32) -> f32| {
            let (mut attitude, mut worst) = (Attitude::default(), 0.0_f32);
            for step in 0..2_000 + (seconds * 1e3) as u32 {
                let tilt = libm::atan2f(acceleration(step), 1.0);
                let sensors = BodySensors {
                    inclination: [if step < 2_000 { 0.0 } else { tilt }, 0.0],
                    ..BodySensors::default()
                };
                attitude.update(&sensors, 1e-3);
                let pitch = attitude.pitch().radians().abs();
                worst = if pitch > worst { pitch } else { worst };
            }
            worst.to_degrees()
        };
        assert!(after(0.5, &|_| 0.5) < 4.0);
        let shaken = |step: u32| {
            if (step / 5).is_multiple_of(2) {
                1.0
            } else {
                -1.0
            }
        };
        assert!(after(10.0, &shaken) < 0.2);
    }

    /// The robot falls onto its legs while the sensors start, or its drives begin to move it: the
    /// first reading, or one after 0.1 s, is off by 30 and -35 degrees. The others are right.
    #[test]
    fn a_wrong_reading_at_the_start_is_forgotten_within_a_second() {
        for (every, at) in [(1, 0), (10, 0), (50, 0), (1, 100), (10, 100), (50, 100)] {
            let mut attitude = Attitude::default();
            for step in 0..1_000 {
                let wrong = if step == at { 1.0 } else { 0.0 };
                let sensors = BodySensors {
                    inclination: [0.2 + 0.52 * wrong, -0.1 - 0.61 * wrong],
                    fresh: if step % every == 0 {
                        Fresh::ALL
                    } else {
                        Fresh::NONE
                    },
                    ..BodySensors::default()
                };
                attitude.update(&sensors, 1e-3);
            }
            let errors = [
                attitude.pitch().radians() - 0.2,
                attitude.roll().radians() + 0.1,
            ]
            .map(|error| error.to_degrees().abs());
            assert!(
                errors.iter().all(|error| *error < 1.0),
                "{every} {at}: {errors:?}"
            );
        }
    }

    /// The guard starts again while the robot drives on at 0.3 m/s.
    #[test]
    fn a_robot_that_moves_when_the_estimate_starts_does_not_accelerate() {
        for rate in [10, 100, 1_000] {
            let (mut attitude, mut worst) = (Attitude::default(), 0.0_f32);
            for step in 0..1_000 {
                if step % 4 == 0 {
                    attitude.travel(300 * step, 4e-3);
                }
                let fresh = Fresh {
                    inclinometer: step > 100 && step % (1_000 / rate) == 0,
                    ..Fresh::ALL
                };
                let sensors = BodySensors {
                    inclination: [0.1, 0.0],
                    fresh,
                    ..BodySensors::default()
                };
                if attitude.update(&sensors, 1e-3) {
                    worst = max(worst, (attitude.pitch().radians() - 0.1).abs());
                }
            }
            assert!(worst < 1e-3, "{rate}: {worst}");
        }
    }

    /// Estimate of the pitch, degrees, 1.5 s after an outage of this sensor for a second, in which
    /// the robot has turned from 0 to 30 degrees. Its first reading afterwards is off by 20
    /// degrees.
    fn after_an_outage(outage: impl Fn(bool) -> Fresh) -> (f32, bool) {
        let (mut attitude, mut settled) = (Attitude::default(), true);
        for step in 0..4_500 {
            let out = (2_000..3_000).contains(&step);
            let wrong = if step == 3_000 { 0.35 } else { 0.0 };
            let turned = if step < 2_000 {
                0.0
            } else {
                core::f32::consts::FRAC_PI_6
            };
            let sensors = BodySensors {
                inclination: [turned + wrong, 0.0],
                fresh: outage(out),
                ..BodySensors::default()
            };
            attitude.update(&sensors, 1e-3);
            if step == 3_010 {
                settled = attitude.settled();
            }
        }
        (attitude.pitch().radians().to_degrees(), settled)
    }

    #[test]
    fn the_estimate_settles_anew_after_an_outage() {
        let no_inclinometer = |out: bool| Fresh {
            inclinometer: !out,
            ..Fresh::ALL
        };
        let no_inertial_unit = |out: bool| if out { Fresh::NONE } else { Fresh::ALL };
        for (pitch, settled) in [
            after_an_outage(no_inclinometer),
            after_an_outage(no_inertial_unit),
        ] {
            assert!((pitch - 30.0).abs() < 0.5, "{pitch}");
            assert!(!settled);
        }
    }

    /// Largest errors of pitch and roll, degrees, on a rigid body that drives on a plane. The plane
    /// is pitched by `slope`, rad. From 3 s on, the body accelerates within 0.25 s to 0.5 m/s and
    /// begins to turn with `yaw_rate`, rad/s, and brakes within 0.25 s after 4 s. The readings are
    /// the difference quotients of its velocity in world axes, in double precision. If `knows`, the
    /// filter gets the distance every 4 ms.
    fn driven(slope: f64, yaw_rate: f64, knows: bool) -> [f64; 2] {
        use core::f64::consts::FRAC_PI_2;
        let speed_at = |time: f64| {
            0.5 * (4.0 * (time - 3.0))
                .min(4.0 * (7.25 - time))
                .clamp(0.0, 1.0)
        };
        // Rows: forward, left and up in world axes. The plane's axes are pitched about y.
        let axes = |heading: f64| {
            let plane = |x: f64, y: f64| [x * libm::cos(slope), y, x * libm::sin(slope)];
            let along = |angle: f64| plane(libm::cos(angle), libm::sin(angle));
            let up = [-libm::sin(slope), 0.0, libm::cos(slope)];
            [along(heading), along(heading + FRAC_PI_2), up]
        };
        let velocity = |time: f64, heading: f64| axes(heading)[0].map(|axis| axis * speed_at(time));
        let (mut attitude, mut worst) = (Attitude::default(), [0.0_f64; 2]);
        let (mut heading, mut distance) = (0.0_f64, 0.0_f64);
        for step in 0..10_000_u32 {
            let time = f64::from(step) * 1e-3;
            let turning = yaw_rate * speed_at(time) / 0.5;
            let before = velocity(time, heading);
            heading += turning * 1e-3;
            distance += speed_at(time) * 1e-3;
            let after = velocity(time + 1e-3, heading);
            let mut force: [f64; 3] =
                core::array::from_fn(|axis| (after[axis] - before[axis]) * 1e3);
            force[2] += 9.806_65;
            let rows = axes(heading);
            let dot = |row: [f64; 3]| row[0] * force[0] + row[1] * force[1] + row[2] * force[2];
            let [x, y, z] = rows.map(dot);
            let sensors = BodySensors {
                inclination: [
                    libm::atan2(x, z) as f32,
                    libm::atan2(y, libm::hypot(x, z)) as f32,
                ],
                angular_rate: [0.0, 0.0, turning as f32],
                fresh: Fresh {
                    inclinometer: step.is_multiple_of(10),
                    ..Fresh::ALL
                },
                ..BodySensors::default()
            };
            attitude.update(&sensors, 1e-3);
            if knows && (step + 1).is_multiple_of(4) {
                attitude.travel((distance * 1e6) as i32, 4e-3);
            }
            let truth = [libm::atan2(rows[0][2], rows[2][2]), libm::asin(rows[1][2])];
            let found = [attitude.pitch(), attitude.roll()];
            for axis in 0..2 {
                let error = (f64::from(found[axis].radians()) - truth[axis])
                    .abs()
                    .to_degrees();
                worst[axis] = if error > worst[axis] {
                    error
                } else {
                    worst[axis]
                };
            }
        }
        worst
    }

    /// A filter that does not know the speed errs by up to 0.5 m/s / (g 2 s) = 1.46 degrees. That
    /// much would also be the roll error of a long turn: 0.25 m/s^2 / g.
    #[test]
    fn accelerations_that_the_drives_explain_do_not_turn_the_estimate() {
        for slope in [0.0_f64, 20.0, -30.0] {
            for yaw_rate in [0.0, 0.5] {
                let [pitch, roll] = driven(slope.to_radians(), yaw_rate, true);
                assert!(
                    pitch < 0.25 && roll < 0.15,
                    "{slope} {yaw_rate}: {pitch} {roll}"
                );
                let [pitch, roll] = driven(slope.to_radians(), yaw_rate, false);
                assert!(
                    (0.9..1.46).contains(&pitch) && roll < 1.46,
                    "{slope}: {pitch} {roll}"
                );
            }
        }
    }

    #[test]
    fn the_direction_up_is_up_in_level_axes() {
        let mut attitude = Attitude::default();
        attitude.update(
            &BodySensors {
                inclination: [0.4, -0.3],
                ..BodySensors::default()
            },
            1e-3,
        );
        let axes = attitude.level_axes();
        let [forward, left, up] = axes.of(axes.up());
        assert!(forward.abs() < 1e-6 && left.abs() < 1e-6 && (up - 1.0).abs() < 1e-6);
    }

    #[test]
    fn level_axes_have_gravity_up() {
        let mut attitude = Attitude::default();
        attitude.update(
            &BodySensors {
                inclination: [0.5, -0.2],
                ..BodySensors::default()
            },
            1e-3,
        );
        let (pitch, roll) = (0.5_f64, -0.2_f64);
        // At this attitude an accelerometer at rest reads the up direction in body axes.
        let up = [
            libm::sin(pitch) * libm::cos(roll),
            libm::sin(roll),
            libm::cos(pitch) * libm::cos(roll),
        ];
        let level = attitude.level(up.map(|value| value as f32));
        assert!(
            level[0].abs() < 1e-6 && level[1].abs() < 1e-6 && (level[2] - 1.0).abs() < 1e-6,
            "{level:?}"
        );
    }

    #[test]
    fn readings_that_are_not_finite_change_nothing() {
        let mut attitude = Attitude::default();
        attitude.update(
            &BodySensors {
                inclination: [f32::NAN, 0.0],
                ..BodySensors::default()
            },
            1e-3,
        );
        assert!(!attitude.known());
    }
}
