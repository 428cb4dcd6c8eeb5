//! The sensors on the body: inclinometer, accelerometer, gyroscope and compass, each with its lag, noise and resolution.

use super::body::{Body, GRAVITY};
use crate::plant::b2p2::parameters::BodySensorParameters;
use crate::plant::noise::Noise;
use rapier3d_f64::math::Vector;
use tautrack::link::BodySensors;

/// Steps between two readings of the compass: ten a second.
const COMPASS_PERIOD: u64 = 100;

/// State of the sensors.
pub struct Sensing {
    noise: Noise,
    velocity: Vector,
    /// Specific force and angular rate behind the inertial unit's low-pass, body axes.
    force: Vector,
    rate: Vector,
    /// Specific force behind the inclinometer's low-pass, body axes.
    slow_force: Vector,
    reading: BodySensors,
}

impl Sensing {
    /// Sensors that have been at rest on `body` for long.
    pub fn new(parameters: &BodySensorParameters, seed: u64, body: &Body) -> Self {
        let at_rest = body.rotation.inverse() * (Vector::Z * GRAVITY);
        let mut sensing = Self {
            noise: Noise::new(seed),
            velocity: Vector::ZERO,
            force: at_rest,
            rate: Vector::ZERO,
            slow_force: at_rest,
            reading: BodySensors::default(),
        };
        sensing.update(parameters, body, 0.0, 0, 1e-3);
        sensing
    }

    /// The last reading.
    pub fn reading(&self) -> BodySensors {
        self.reading
    }

    /// What the next reading depends on beside the body, in a fixed order.
    pub fn state(&self) -> [Vector; 4] {
        [self.velocity, self.force, self.rate, self.slow_force]
    }

    /// Senses `body` after step number `step` of `dt`; `heading` is the true one, rad.
    pub fn update(
        &mut self,
        parameters: &BodySensorParameters,
        body: &Body,
        heading: f64,
        step: u64,
        dt: f64,
    ) {
        let p = parameters;
        let into_body = body.rotation.inverse();
        let velocity = body.velocity_at(body.place(Vector::from_array(p.accelerometer_place)));
        let acceleration = (velocity - self.velocity) / dt;
        self.velocity = velocity;
        let force = into_body * (acceleration + Vector::Z * GRAVITY);
        let inertial = dt / (p.inertial_lag + dt);
        self.force += (force - self.force) * inertial;
        self.rate += (into_body * body.spin - self.rate) * inertial;
        self.slow_force += (force - self.slow_force) * (dt / (p.inclination_lag + dt));

        let read = |channel: usize, value: f64, [sigma, quantum]: [f64; 2]| {
            self.noise
                .reading(step, channel as u64, value, sigma, quantum) as f32
        };
        let [x, y, z] = self.slow_force.to_array();
        let inclination = [libm::atan2(x, z), libm::atan2(y, libm::sqrt(x * x + z * z))];
        self.reading.inclination =
            [0, 1].map(|i| read(i, inclination[i] + p.inclination_offset[i], p.inclination));
        self.reading.specific_force =
            [0, 1, 2].map(|i| read(2 + i, self.force[i], p.specific_force));
        let rate = self.rate + Vector::from_array(p.angular_rate_bias);
        self.reading.angular_rate = [0, 1, 2].map(|i| read(5 + i, rate[i], p.angular_rate));
        if step.is_multiple_of(COMPASS_PERIOD) {
            self.reading.heading = read(8, heading, p.heading);
        }
    }
}
