//! The sensors on segment 1: inclinometer, accelerometer, gyroscope and magnetometer, each with its lag, noise and resolution.

use super::parameters::BodySensorParameters;
use super::robot::{DT, GRAVITY, into_body};
use crate::plant::noise::Noise;
use rapier3d_f64::math::Vector;
use rapier3d_f64::prelude::*;
use tautrack::link::BodySensors;

/// Steps between two readings of the magnetometer: ten a second.
const MAGNETOMETER_PERIOD: u64 = 100;

/// State of the sensors.
pub struct BodySensing {
    noise: Noise,
    accelerometer_velocity: Vector,
    /// Specific force and angular rate behind the inertial unit's low-pass, body axes.
    specific_force: Vector,
    angular_rate: Vector,
    /// Specific force behind the inclinometer's low-pass, body axes.
    inclination_force: Vector,
    reading: BodySensors,
}

impl BodySensing {
    /// Sensors that have been at rest on `body` for long.
    pub fn new(parameters: &BodySensorParameters, noise: Noise, body: &RigidBody) -> Self {
        let at_rest = into_body(body, Vector::Z * GRAVITY);
        let mut sensing = Self {
            noise,
            accelerometer_velocity: Vector::ZERO,
            specific_force: at_rest,
            angular_rate: Vector::ZERO,
            inclination_force: at_rest,
            reading: BodySensors::default(),
        };
        sensing.update(parameters, body, 0);
        sensing
    }

    /// The last reading.
    pub fn reading(&self) -> BodySensors {
        self.reading
    }

    /// Filter states in a fixed order: what the next reading depends on beside the bodies.
    pub fn state(&self) -> [Vector; 4] {
        [
            self.accelerometer_velocity,
            self.specific_force,
            self.angular_rate,
            self.inclination_force,
        ]
    }

    /// Senses `body` after step number `step`.
    pub fn update(&mut self, parameters: &BodySensorParameters, body: &RigidBody, step: u64) {
        let p = parameters;
        let place = body
            .position()
            .transform_point(Vector::from_array(p.accelerometer_place));
        let velocity = body.velocity_at_point(place);
        let acceleration = if step == 0 {
            Vector::ZERO
        } else {
            (velocity - self.accelerometer_velocity) / DT
        };
        self.accelerometer_velocity = velocity;
        let force = into_body(body, acceleration + Vector::Z * GRAVITY);
        let inertial = DT / (p.inertial_lag + DT);
        self.specific_force += (force - self.specific_force) * inertial;
        self.angular_rate += (into_body(body, body.angvel()) - self.angular_rate) * inertial;
        self.inclination_force +=
            (force - self.inclination_force) * (DT / (p.inclination_lag + DT));

        let read = |channel: usize, value: f64, [sigma, quantum]: [f64; 2]| {
            self.noise
                .reading(step, channel as u64, value, sigma, quantum) as f32
        };
        let [x, y, z] = self.inclination_force.to_array();
        let inclination = [libm::atan2(x, z), libm::atan2(y, libm::sqrt(x * x + z * z))];
        self.reading.inclination = core::array::from_fn(|i| {
            read(i, inclination[i] + p.inclination_offset[i], p.inclination)
        });
        self.reading.specific_force =
            core::array::from_fn(|i| read(2 + i, self.specific_force[i], p.specific_force));
        self.reading.angular_rate = core::array::from_fn(|i| {
            read(
                5 + i,
                self.angular_rate[i] + p.angular_rate_bias[i],
                p.angular_rate,
            )
        });
        if step.is_multiple_of(MAGNETOMETER_PERIOD) {
            let [strength, inclination, declination] = p.earth_field;
            let level = strength * libm::cos(inclination);
            // x north, y west, z up.
            let earth = Vector::new(
                level * libm::cos(declination),
                -level * libm::sin(declination),
                -strength * libm::sin(inclination),
            );
            let field = into_body(body, earth) + Vector::from_array(p.hard_iron);
            self.reading.magnetic_field =
                core::array::from_fn(|i| read(8 + i, field[i], p.magnetic_field));
        }
    }
}
