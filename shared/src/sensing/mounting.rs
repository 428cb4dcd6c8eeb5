//! Turns the readings of the sensors on the body from the axes of the sensor board to those of the
//! body, and subtracts their constant errors.

use crate::estimate::attitude::pitch_and_roll;
use crate::math::sin_cos;
use crate::sensors::BodySensors;
use crate::settings::{Setting, Settings};
use crate::units::Angle;

/// How the sensor board is mounted on the body, and the constant errors of its sensors.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Mounting {
    /// Rotation from the axes of the board to those of the body; `None` if they are the same.
    rotation: Option<[[f32; 3]; 3]>,
    /// Reading of the gyroscope at rest, in body axes, rad/s.
    rate_at_rest: [f32; 3],
    /// Pitch and roll that the inclinometer shows on level ground, rad.
    level: [f32; 2],
}

impl Mounting {
    /// Mounting with these angles, turned about x, then y, then z of the body, and with these
    /// constant errors.
    pub fn new([about_x, about_y, about_z]: [Angle; 3], rate: [f32; 3], level: [f32; 2]) -> Self {
        let turned = [about_x, about_y, about_z] != [Angle::ZERO; 3];
        Self {
            rotation: turned.then(|| rotation([about_x, about_y, about_z])),
            rate_at_rest: rate,
            level,
        }
    }

    /// Reads the mounting from the settings.
    pub fn with_settings(settings: &Settings) -> Self {
        let degrees = |setting| Angle::from_degrees(settings.si(setting));
        let radians = |setting| settings.si(setting).to_radians();
        Self::new(
            [
                degrees(Setting::MountingX),
                degrees(Setting::MountingY),
                degrees(Setting::MountingZ),
            ],
            [
                radians(Setting::RateAtRestX),
                radians(Setting::RateAtRestY),
                radians(Setting::RateAtRestZ),
            ],
            [radians(Setting::LevelPitch), radians(Setting::LevelRoll)],
        )
    }

    /// Turns a vector from the axes of the board to those of the body.
    pub fn turn(&self, vector: [f32; 3]) -> [f32; 3] {
        self.rotation.map_or(vector, |rows| {
            rows.map(|row| row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2])
        })
    }

    /// Returns the readings in body axes without the constant errors. The magnetometer keeps its
    /// hard iron.
    pub fn apply(&self, sensors: &BodySensors) -> BodySensors {
        let rate = self.turn(sensors.angular_rate);
        let inclination = self.inclination(sensors.inclination);
        BodySensors {
            inclination: core::array::from_fn(|axis| inclination[axis] - self.level[axis]),
            specific_force: self.turn(sensors.specific_force),
            angular_rate: core::array::from_fn(|axis| rate[axis] - self.rate_at_rest[axis]),
            magnetic_field: self.turn(sensors.magnetic_field),
            fresh: sensors.fresh,
        }
    }

    /// Turns pitch and roll of the board, rad, to those of the body.
    pub fn inclination(&self, inclination: [f32; 2]) -> [f32; 2] {
        if self.rotation.is_none() {
            return inclination;
        }
        let [pitch, roll] = inclination.map(|angle| sin_cos(Angle::from_radians(angle)));
        pitch_and_roll(self.turn([pitch.0 * roll.1, roll.0, pitch.1 * roll.1]))
    }
}

/// Rotation about x, then y, then z.
fn rotation(angles: [Angle; 3]) -> [[f32; 3]; 3] {
    let [(sx, cx), (sy, cy), (sz, cz)] = angles.map(sin_cos);
    [
        [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
        [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
        [-sy, cy * sx, cy * cx],
    ]
}
