//! What acts on the sensors on a robot's body: inclinometer, accelerometer, gyroscope and
//! magnetometer, each with lag and noise. Rate and resolution are those of the chips, which the
//! guard's node simulates.

use super::noise::Noise;
use rapier3d_f64::dynamics::RigidBody;
use rapier3d_f64::math::{Rotation, Vector};
use tautrack::constants::GRAVITY_F64;
use tautrack::link::BodyMeasurands;

/// Properties of the sensors on the body. Noise is a standard deviation.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct BodySensorParameters {
    /// Time constant of inclinometer, accelerometer and gyroscope, s.
    pub inertial_lag: f64,
    /// Noise of the inclinometer, m/s^2.
    pub tilt_force: f64,
    /// Place of accelerometer and inclinometer, which are on one board, relative to the body's
    /// origin: forward, left, up, m.
    pub accelerometer_place: [f64; 3],
    /// Noise of the accelerometer, m/s^2.
    pub specific_force: f64,
    /// Noise of the gyroscope, rad/s.
    pub angular_rate: f64,
    /// Constant error of the gyroscope, rad/s.
    pub angular_rate_bias: [f64; 3],
    /// Noise of the magnetometer, uT.
    pub magnetic_field: f64,
    /// Field of the robot's own magnets (hard iron) in body axes, uT.
    pub hard_iron: [f64; 3],
    /// The earth's field: strength, uT; inclination below the horizon and declination east of true
    /// north, rad.
    pub earth_field: [f64; 3],
}

impl BodySensorParameters {
    /// Typical sensors for robots of this size.
    pub const NOMINAL: Self = Self {
        inertial_lag: 0.005,
        // 220 ug per root of Hz in the bandwidth of 50 Hz.
        tilt_force: 0.015,
        accelerometer_place: [0.16, 0.0, 0.05],
        specific_force: 0.03,
        angular_rate: 0.003,
        angular_rate_bias: [0.002, -0.002, 0.001],
        magnetic_field: 0.15,
        hard_iron: [8.0, -5.0, 12.0],
        earth_field: [47.5, 62.0_f64.to_radians(), 1.0_f64.to_radians()],
    };
}

/// Motion of a body. Body axes are x forward, y left, z up.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct BodyMotion {
    /// Rotation from body axes to world axes.
    pub rotation: Rotation,
    /// Velocity of the accelerometer's place in world axes, m/s.
    pub velocity: Vector,
}

impl BodyMotion {
    /// Motion of a rigid body whose axes are the robot's.
    pub fn of(body: &RigidBody, parameters: &BodySensorParameters) -> Self {
        let place = Vector::from_array(parameters.accelerometer_place);
        Self {
            rotation: body.position().rotation,
            velocity: body.velocity_at_point(body.position().transform_point(place)),
        }
    }
}

/// Length of a step, s.
const DT: f64 = 1e-3;

/// Small rotation from one attitude to the next, rad, in body axes.
///
/// The gyroscope measures this rotation and not the solver's angular velocity, because the solver's
/// position corrections, which push bodies out of each other, are not part of that velocity. A
/// front pressed onto the ground turns the body by some 0.2 rad/s more.
fn turned(from: Rotation, to: Rotation) -> Vector {
    let turn = from.inverse() * to;
    // Half the angle is small and therefore equal to its sine. A rotation and its negative are the
    // same.
    let twice = if turn.w < 0.0 { -2.0 } else { 2.0 };
    Vector::new(turn.x, turn.y, turn.z) * twice
}

/// The earth's field in world axes: x north, y west, z up, uT.
fn earth_field(parameters: &BodySensorParameters) -> Vector {
    let [strength, inclination, declination] = parameters.earth_field;
    let level = strength * libm::cos(inclination);
    Vector::new(
        level * libm::cos(declination),
        -level * libm::sin(declination),
        -strength * libm::sin(inclination),
    )
}

/// State of the sensors.
pub struct BodySensing {
    noise: Noise,
    /// Rotation of the body in the previous step.
    rotation: Rotation,
    accelerometer_velocity: Vector,
    /// Low-pass filtered specific force and angular rate, in body axes.
    specific_force: Vector,
    angular_rate: Vector,
    /// The earth's field in world axes, uT.
    earth_field: Vector,
    reading: BodyMeasurands,
}

impl BodySensing {
    /// Creates sensors that have been at rest for long, on a body in this attitude.
    pub fn new(parameters: &BodySensorParameters, noise: Noise, rotation: Rotation) -> Self {
        let at_rest = rotation.inverse() * (Vector::Z * GRAVITY_F64);
        let mut sensing = Self {
            noise,
            rotation,
            accelerometer_velocity: Vector::ZERO,
            specific_force: at_rest,
            angular_rate: Vector::ZERO,
            earth_field: earth_field(parameters),
            reading: BodyMeasurands::default(),
        };
        sensing.update(
            parameters,
            &BodyMotion {
                rotation,
                velocity: Vector::ZERO,
            },
            0,
        );
        sensing
    }

    /// Returns what acts on the sensors.
    pub fn reading(&self) -> BodyMeasurands {
        self.reading
    }

    /// Passes the state of the sensors and the last reading to `put`, in a fixed order. The next
    /// reading depends on this state and on the motion of the body.
    pub fn bits(&self, put: &mut dyn FnMut(f64)) {
        let rotation = self.rotation;
        [rotation.x, rotation.y, rotation.z, rotation.w]
            .into_iter()
            .for_each(&mut *put);
        for vector in [
            self.accelerometer_velocity,
            self.specific_force,
            self.angular_rate,
        ] {
            vector.to_array().into_iter().for_each(&mut *put);
        }
        let readings = [
            &self.reading.tilt_force[..],
            &self.reading.specific_force,
            &self.reading.angular_rate,
            &self.reading.magnetic_field,
        ];
        for value in readings.into_iter().flatten() {
            put(f64::from(*value));
        }
    }

    /// Updates the readings after step number `step`.
    pub fn update(&mut self, parameters: &BodySensorParameters, motion: &BodyMotion, step: u64) {
        let p = parameters;
        let BodyMotion { rotation, velocity } = *motion;
        let into_body = rotation.inverse();
        let acceleration = if step == 0 {
            Vector::ZERO
        } else {
            (velocity - self.accelerometer_velocity) / DT
        };
        self.accelerometer_velocity = velocity;
        let force = into_body * (acceleration + Vector::Z * GRAVITY_F64);
        let inertial = DT / (p.inertial_lag + DT);
        self.specific_force += (force - self.specific_force) * inertial;
        let turn = turned(self.rotation, rotation);
        self.rotation = rotation;
        self.angular_rate += (turn / DT - self.angular_rate) * inertial;
        let angular_rate = self.angular_rate + Vector::from_array(p.angular_rate_bias);
        let field = into_body * self.earth_field + Vector::from_array(p.hard_iron);
        let noisy = |channel: usize, values: Vector, sigma: f64| {
            core::array::from_fn(|i| {
                let channel = (channel + i) as u64;
                self.noise.reading(step, channel, values[i], sigma, 0.0) as f32
            })
        };
        self.reading = BodyMeasurands {
            specific_force: noisy(2, self.specific_force, p.specific_force),
            angular_rate: noisy(5, angular_rate, p.angular_rate),
            magnetic_field: noisy(8, field, p.magnetic_field),
            tilt_force: noisy(11, self.specific_force, p.tilt_force),
            ..BodyMeasurands::default()
        };
    }
}
