//! Estimates pitch, roll and heading from the gyroscope, the inclinometer and the compass.
//!
//! The integrated rates drift, the inclinometer lags, and the compass is slow. A complementary
//! filter combines the three.

use crate::math::{limit, sin_cos};
use crate::sensors::BodySensors;
use crate::units::Angle;

/// Time constant of the inclinometer's lag, s.
const INCLINOMETER_LAG: f32 = 0.3;
/// Time constant with which the inclinometer corrects pitch and roll, s.
const LEVEL_TIME: f32 = 2.0;
/// Time constant with which the compass corrects the heading, s.
const HEADING_TIME: f32 = 2.0;

/// Complementary filter for pitch, roll and heading.
///
/// The angles are q6, q5 and q4 of Paillat et al.: roll about the heading, then pitch about the
/// robot's transverse axis. Nose up, left side up and counter-clockwise are positive.
///
/// The filter compares the inclinometer with a copy of the estimate that lags as much as the
/// inclinometer does. So the lag does not pull the estimate back during a fast swing.
#[derive(Clone, Debug, Default)]
pub struct Attitude {
    tilt: Option<[Angle; 2]>,
    late: [f32; 2],
    pitch_rate: f32,
    heading: Angle,
    began: bool,
}

impl Attitude {
    /// Updates the estimate with one set of readings, `period` s after the previous one. If an
    /// inclination or an angular rate is not finite, returns false and changes nothing.
    pub fn update(&mut self, sensors: &BodySensors, period: f32) -> bool {
        let [pitch_level, roll_level] = sensors.inclination;
        if !sensors
            .inclination
            .iter()
            .chain(&sensors.angular_rate)
            .all(|value| value.is_finite())
        {
            return false;
        }
        let level = [
            Angle::from_radians(pitch_level),
            Angle::from_radians(roll_level),
        ];
        self.began = self.tilt.is_none();
        let [pitch, roll] = *self.tilt.get_or_insert(level);

        let [rate_x, rate_y, rate_z] = sensors.angular_rate;
        let (sine, cosine) = sin_cos(pitch);
        let yaw_rate = rate_x * sine + rate_z * cosine;
        let rates = [
            yaw_rate * sin_cos(roll).0 - rate_y,
            rate_x * cosine - rate_z * sine,
        ];
        self.pitch_rate = rates[0];

        let mut tilt = [pitch, roll];
        for axis in 0..2 {
            let error = (level[axis] - tilt[axis]).radians() + self.late[axis];
            let step = (rates[axis] + error / LEVEL_TIME) * period;
            tilt[axis] += Angle::from_radians(step);
            // `late` is the estimate minus its lagging copy, rad.
            self.late[axis] += step - self.late[axis] * (period / INCLINOMETER_LAG);
        }
        self.tilt = Some(tilt);
        self.heading += Angle::from_radians(yaw_rate * period);
        true
    }

    /// Corrects the heading with a compass heading that counts for `period` s. Call it after
    /// [`Self::update`].
    ///
    /// A compass heading that comes with the first readings becomes the heading. Later ones change
    /// it by at most 0.25 rad/s, so that a late or wrong compass cannot make a robot that holds its
    /// heading turn on the spot.
    pub fn correct_heading(&mut self, compass: Angle, period: f32) {
        let error = compass - self.heading;
        self.heading += if self.began {
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
