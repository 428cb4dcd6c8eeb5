//! Sensors on a robot's body: inclinometer, accelerometer, gyroscope and magnetometer, each with
//! lag, noise and resolution.

use super::noise::Noise;
use rapier3d_f64::dynamics::RigidBody;
use rapier3d_f64::math::{Rotation, Vector};
use tautrack::constants::GRAVITY_F64;
use tautrack::sensors::BodySensors;

/// Number of steps between two readings of the magnetometer, which reads ten times per second.
const MAGNETOMETER_PERIOD: u64 = 100;

/// Properties of the sensors on the body. Noise is a standard deviation.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct BodySensorParameters {
    /// Time constant of the inclinometer, s.
    pub inclination_lag: f64,
    /// Noise and resolution of the inclinometer, rad.
    pub inclination: [f64; 2],
    /// Offset of the inclinometer: pitch and roll, rad.
    pub inclination_offset: [f64; 2],
    /// Time constant of accelerometer and gyroscope, s.
    pub inertial_lag: f64,
    /// Place of the accelerometer relative to the body's origin: forward, left, up, m.
    pub accelerometer_place: [f64; 3],
    /// Noise and resolution of the accelerometer, m/s^2.
    pub specific_force: [f64; 2],
    /// Noise and resolution of the gyroscope, rad/s.
    pub angular_rate: [f64; 2],
    /// Constant error of the gyroscope, rad/s.
    pub angular_rate_bias: [f64; 3],
    /// Noise and resolution of the magnetometer, uT.
    pub magnetic_field: [f64; 2],
    /// Field of the robot's own magnets (hard iron) in body axes, uT.
    pub hard_iron: [f64; 3],
    /// The earth's field: strength, uT; inclination below the horizon and declination east of true
    /// north, rad.
    pub earth_field: [f64; 3],
}

impl BodySensorParameters {
    /// Typical sensors for robots of this size.
    pub const NOMINAL: Self = Self {
        inclination_lag: 0.3,
        inclination: [0.001, 0.0005],
        inclination_offset: [0.0; 2],
        inertial_lag: 0.005,
        accelerometer_place: [0.16, 0.0, 0.05],
        specific_force: [0.03, 0.005],
        angular_rate: [0.003, 0.001],
        angular_rate_bias: [0.002, -0.002, 0.001],
        magnetic_field: [0.15, 0.1],
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

/// State of the sensors.
pub struct BodySensing {
    noise: Noise,
    /// Rotation of the body in the previous step.
    rotation: Rotation,
    accelerometer_velocity: Vector,
    /// Low-pass filtered specific force and angular rate of the inertial unit, in body axes.
    specific_force: Vector,
    angular_rate: Vector,
    /// Low-pass filtered specific force of the inclinometer, in body axes.
    inclination_force: Vector,
    reading: BodySensors,
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
            inclination_force: at_rest,
            reading: BodySensors::default(),
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

    /// Returns the last reading.
    pub fn reading(&self) -> BodySensors {
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
            self.inclination_force,
        ] {
            vector.to_array().into_iter().for_each(&mut *put);
        }
        let readings = [
            &self.reading.inclination[..],
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
            // World axes: x north, y west, z up.
            let earth = Vector::new(
                level * libm::cos(declination),
                -level * libm::sin(declination),
                -strength * libm::sin(inclination),
            );
            let field = into_body * earth + Vector::from_array(p.hard_iron);
            self.reading.magnetic_field =
                core::array::from_fn(|i| read(8 + i, field[i], p.magnetic_field));
        }
    }
}
