//! Sensor board that is not mounted along the axes of the body, with constant errors of its
//! sensors.

use super::physics::turn;
use rapier3d_f64::math::{Rotation, Vector};
use tautrack::link::BodyMeasurands;

/// Mounting of the board and constant errors of its sensors.
#[derive(Clone, Copy, Debug)]
pub struct SensorBoard {
    /// Rotation from body axes to the axes of the board.
    from_body: Rotation,
    /// Constant error of the gyroscope in the axes of the board, rad/s.
    rate: Vector,
    /// Constant error of the accelerometer in the axes of the board, m/s^2.
    force: Vector,
    /// Field of the robot's magnets in body axes, uT.
    hard_iron: Vector,
    /// Amplification of the field by iron, forward and to the left, and the coupling of the two, as
    /// fractions.
    soft_iron: [f64; 3],
    /// Rotation of the force by the constant errors of pitch and roll.
    level: Rotation,
}

impl SensorBoard {
    /// Creates a board that is turned by the angles of `mounting`, rad, about x, then y, then z of
    /// the body. The other values are those of the fields, in the same order.
    pub fn new(
        mounting: [f64; 3],
        rate: [f64; 3],
        force: [f64; 3],
        hard_iron: [f64; 3],
        soft_iron: [f64; 3],
        level: [f64; 2],
    ) -> Self {
        let [x, y, z] = mounting;
        let to_body = turn(Vector::Z, z) * turn(Vector::Y, y) * turn(Vector::X, x);
        Self {
            from_body: to_body.inverse(),
            rate: Vector::from_array(rate),
            force: Vector::from_array(force),
            hard_iron: Vector::from_array(hard_iron),
            soft_iron,
            level: turn(Vector::Y, level[0]) * turn(Vector::NEG_X, level[1]),
        }
    }

    /// Returns what acts on the sensors of this board, where `body` would act on sensors along the
    /// axes of the body.
    pub fn measurands(&self, body: BodyMeasurands) -> BodyMeasurands {
        let vector = |values: [f32; 3]| Vector::from_array(values.map(f64::from));
        let readings = |values: Vector| values.to_array().map(|value| value as f32);
        let [x, y, z] = vector(body.magnetic_field).to_array();
        let [forward, left, cross] = self.soft_iron;
        let field = Vector::new(
            (1.0 + forward) * x + cross * y,
            cross * x + (1.0 + left) * y,
            z,
        );
        BodyMeasurands {
            tilt_force: readings(self.level * self.from_body * vector(body.tilt_force)),
            specific_force: readings(self.from_body * vector(body.specific_force) + self.force),
            angular_rate: readings(self.from_body * vector(body.angular_rate) + self.rate),
            magnetic_field: readings(self.from_body * (field + self.hard_iron)),
            ..body
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::FRAC_PI_2;

    /// Readings of a board with this mounting and no other error.
    fn mounted(mounting: [f64; 3], body: BodyMeasurands) -> BodyMeasurands {
        SensorBoard::new(mounting, [0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3], [0.0; 2])
            .measurands(body)
    }

    fn near(found: &[f32], expected: &[f32]) {
        let close = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-6;
        assert!(found.iter().zip(expected).all(close), "{found:?}");
    }

    #[test]
    fn a_board_turned_a_quarter_shows_each_axis_of_the_body_on_the_expected_axis() {
        let body = BodyMeasurands {
            tilt_force: [0.1, 0.0, 0.9],
            specific_force: [1.0, 2.0, 3.0],
            ..BodyMeasurands::default()
        };
        // The board's x axis points to the robot's left: nose up is its right side up.
        let about_z = mounted([0.0, 0.0, FRAC_PI_2], body);
        near(&about_z.specific_force, &[2.0, -1.0, 3.0]);
        near(&about_z.tilt_force, &[0.0, -0.1, 0.9]);
        // Its left side points up, and its x axis points down.
        near(
            &mounted([FRAC_PI_2, 0.0, 0.0], body).specific_force,
            &[1.0, 3.0, -2.0],
        );
        near(
            &mounted([0.0, FRAC_PI_2, 0.0], body).specific_force,
            &[-3.0, 2.0, 1.0],
        );
        // About x first: the board's z axis points to the right, and the turn about z makes it
        // point forward.
        near(
            &mounted([FRAC_PI_2, 0.0, FRAC_PI_2], body).specific_force,
            &[2.0, 3.0, 1.0],
        );
    }

    #[test]
    fn constant_errors_are_added_in_their_axes() {
        let body = BodyMeasurands {
            tilt_force: [0.0, 0.0, 9.81],
            angular_rate: [0.1, 0.2, 0.3],
            specific_force: [1.0, 2.0, 3.0],
            magnetic_field: [10.0, 20.0, -40.0],
            ..BodyMeasurands::default()
        };
        let board = SensorBoard::new(
            [0.0, 0.0, FRAC_PI_2],
            [0.01, 0.02, 0.03],
            [0.5, -1.0, 0.2],
            [1.0, 2.0, 3.0],
            [0.1, -0.1, 0.05],
            [0.0; 2],
        );
        let found = board.measurands(body);
        near(&found.angular_rate, &[0.21, -0.08, 0.33]);
        near(&found.specific_force, &[2.5, -2.0, 3.2]);
        // In body axes (10 * 1.1 + 20 * 0.05 + 1, 10 * 0.05 + 20 * 0.9 + 2, -37).
        near(&found.magnetic_field, &[20.5, -13.0, -37.0]);
        let tilted = SensorBoard::new(
            [0.0; 3],
            [0.0; 3],
            [0.0; 3],
            [0.0; 3],
            [0.0; 3],
            [0.01, -0.02],
        );
        let [x, y, z] = tilted.measurands(body).tilt_force;
        near(
            &[libm::atan2f(x, z), libm::atan2f(y, libm::hypotf(x, z))],
            &[0.01, -0.02],
        );
    }
}
