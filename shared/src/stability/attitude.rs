//! Estimates pitch, roll and heading from the gyroscope, the inclinometer and the compass.
//!
//! The integrated rates drift, the inclinometer lags, and the compass is slow. A complementary
//! filter combines the three.

use crate::math::{limit, min, sin_cos};
use crate::sensors::{BodySensors, Fresh};
use crate::units::Angle;

/// Time constant of the inclinometer's lag, s.
const INCLINOMETER_LAG: f32 = 0.3;
/// Time constant with which the inclinometer corrects pitch and roll, s.
const LEVEL_TIME: f32 = 2.0;
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

/// Complementary filter for pitch, roll and heading.
///
/// The angles are q6, q5 and q4 of Paillat et al.: roll about the heading, then pitch about the
/// robot's transverse axis. Nose up, left side up and counter-clockwise are positive.
///
/// The filter compares the inclinometer with a copy of the estimate that lags as much as the
/// inclinometer does. So the lag does not pull the estimate back during a fast swing.
///
/// Each sensor measures at its own rate. Between two readings of the gyroscope the estimate goes on
/// with the last one, for at most [`HOLD_LIMIT`]. When the next one comes, the time between them
/// counts with their mean.
#[derive(Clone, Debug, Default)]
pub struct Attitude {
    tilt: Option<[Angle; 2]>,
    late: [f32; 2],
    /// Inclinometer minus the lagging copy of the estimate, rad.
    contradiction: [f32; 2],
    pitch_rate: f32,
    heading: Angle,
    /// Time since the first inclination, s, up to [`HEADING_WAIT`], and whether a compass heading
    /// has come.
    running: f32,
    headed: bool,
    /// Newest angular rate in body axes, rad/s, and for how long the estimate has used it, s.
    angular_rate: [f32; 3],
    held: f32,
    /// Time since the newest inclination, s.
    levelled: f32,
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
        if self.tilt.is_some() {
            self.running = min(self.running + period, HEADING_WAIT);
        }
        let Some([pitch, roll]) = self.tilt.or(level) else {
            return false;
        };
        let rate = (gyroscope && finite(&sensors.angular_rate)).then_some(sensors.angular_rate);
        let [rate_x, rate_y, rate_z] = self.mean_rate(rate, period);
        let (sine, cosine) = sin_cos(pitch);
        let yaw_rate = rate_x * sine + rate_z * cosine;
        let rates = [
            yaw_rate * sin_cos(roll).0 - rate_y,
            rate_x * cosine - rate_z * sine,
        ];
        let [x, y, z] = self.angular_rate;
        self.pitch_rate = (x * sine + z * cosine) * sin_cos(roll).0 - y;

        self.levelled = min(self.levelled + period, LONGEST_CORRECTION);
        // A reading corrects for the time since the previous one.
        let weight = ratio(self.levelled, period);
        let mut tilt = [pitch, roll];
        for axis in 0..2 {
            let mut rate = rates[axis];
            if let Some(level) = level {
                let error = (level[axis] - tilt[axis]).radians() + self.late[axis];
                self.contradiction[axis] = error;
                rate += error * weight / LEVEL_TIME;
            }
            let step = rate * period;
            tilt[axis] += Angle::from_radians(step);
            // `late` is the estimate minus its lagging copy, rad.
            self.late[axis] += step - self.late[axis] * (period / INCLINOMETER_LAG);
        }
        if level.is_some() {
            self.levelled = 0.0;
        }
        self.tilt = Some(tilt);
        self.heading += Angle::from_radians(yaw_rate * period);
        true
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

    /// Inclinometer minus what it should read by the estimate, at its newest reading: pitch and
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

/// Returns `time / period`; 0 if there is no period.
fn ratio(time: f32, period: f32) -> f32 {
    if period > 0.0 { time / period } else { 0.0 }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Simulates a swing about the transverse axis with an ideal gyroscope and a lagging
    /// inclinometer.
    #[test]
    fn follows_a_fast_swing_although_the_inclinometer_is_late() {
        let (mut attitude, mut lagging, mut worst) = (Attitude::default(), 0.0_f64, 0.0_f64);
        for step in 0..8_000 {
            let time = f64::from(step) * 1e-3;
            let (pitch, rate) = (0.4 * libm::sin(3.0 * time), 1.2 * libm::cos(3.0 * time));
            lagging += (pitch - lagging) * 1e-3 / 0.3;
            let sensors = BodySensors {
                inclination: [lagging as f32, 0.0],
                angular_rate: [0.0, -rate as f32, 0.0],
                ..BodySensors::default()
            };
            attitude.update(&sensors, 1e-3);
            let error = (f64::from(attitude.pitch().radians()) - pitch).abs();
            worst = if error > worst { error } else { worst };
        }
        assert!(worst < 0.01, "worst error {worst} rad");
    }

    /// Simulates the same swing with readings of inclinometer and gyroscope at these rates.
    #[test]
    fn follows_a_fast_swing_at_50_hz() {
        for (rate, allowed) in [(200, 0.011), (100, 0.012), (50, 0.02), (20, 0.08)] {
            let (mut attitude, mut lagging, mut worst) = (Attitude::default(), 0.0_f64, 0.0_f64);
            for step in 0..8_000 {
                let time = f64::from(step) * 1e-3;
                let (pitch, turning) = (0.4 * libm::sin(3.0 * time), 1.2 * libm::cos(3.0 * time));
                lagging += (pitch - lagging) * 1e-3 / 0.3;
                let new = step % (1_000 / rate) == 0;
                let sensors = BodySensors {
                    inclination: [lagging as f32, 0.0],
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
