//! RT-Mover of Nakajima: body, seat on its pitch shaft, two arms that steer and roll, four wheels; nine motors.
//!
//! [`parameters`]: the constant model. `robot`: bodies and joints in the physics engine. Here: the order of one step.

pub mod parameters;
mod robot;

pub use parameters::RtMoverParameters;
pub use robot::MOTORS;

use crate::plant::b2p2::gear::{Drive, Gear};
use crate::plant::b2p2::robot::{DT, GRAVITY, SUBSTEPS, world};
use crate::plant::b2p2::sense::BodySensing;
use crate::plant::noise::Noise;
use crate::plant::terrain::Terrain;
use core::f64::consts::TAU;
use rapier3d_f64::math::{Pose, Vector};
use rapier3d_f64::prelude::*;
use robot::{Robot, SEAT};
use tautrack::link::{BodySensors, Sensors, Shaft, Switches};

/// What the physics knows; metres and radians, world axes x forward, y left, z up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RtMoverTruth {
    /// Middle of the body.
    pub middle: [f64; 3],
    /// Pitch, front up, and roll, left up, of the seat.
    pub seat: [f64; 2],
    /// Heading of the body, counter-clockwise.
    pub yaw: f64,
    /// Centre of gravity.
    pub cog: [f64; 3],
    /// Lowest points of the wheels.
    pub wheels: [[f64; 3]; 4],
    /// Upward force of the ground on each wheel, N.
    pub loads: [f64; 4],
    /// Turned over; stays set.
    pub toppled: bool,
}

/// RT-Mover on its ground.
pub struct RtMover {
    parameters: RtMoverParameters,
    world: PhysicsWorld,
    robot: Robot,
    gears: [Gear; MOTORS],
    rates: [f64; MOTORS],
    sensing: BodySensing,
    step: u64,
    truth: RtMoverTruth,
}

/// Tilt of the seat from which the robot counts as turned over, rad.
const TURNED_OVER: f64 = 1.0;

impl RtMover {
    /// The robot at the origin of `terrain`; `seed` is that of the sensors' noise.
    pub fn new(parameters: &RtMoverParameters, terrain: &Terrain, seed: u64) -> Self {
        let p = *parameters;
        let mut world = world();
        for block in terrain.blocks() {
            let [x, y, z] = block.half;
            world.insert_collider(
                ColliderBuilder::cuboid(x, y, z)
                    .position(Pose::from_translation(Vector::from_array(block.centre)))
                    .friction(p.friction),
                None,
            );
        }
        let robot = Robot::build(&mut world, &p);
        let seat = &world.bodies[robot.bodies[SEAT]];
        let sensing = BodySensing::new(&p.body_sensors, Noise::new(seed), seat);
        let mut plant = Self {
            gears: core::array::from_fn(|motor| {
                if motor < 4 {
                    Gear::new([0.0, p.wheel_gear], TAU, Some(p.dead_wheel_friction), 0.0)
                } else {
                    Gear::new(p.shaft_gear, TAU, None, 0.0)
                }
            }),
            rates: [0.0; MOTORS],
            step: 0,
            truth: RtMoverTruth::default(),
            parameters: p,
            world,
            robot,
            sensing,
        };
        plant.observe();
        plant
    }

    /// Advances by one millisecond, as [`crate::plant::Plant::step`] does.
    pub fn step(&mut self, shafts: &[Option<Shaft>; MOTORS]) {
        let before = self.robot.shafts.map(|shaft| shaft.angle(&self.world));
        for (motor, shaft) in shafts.iter().enumerate() {
            let drive = self.gears[motor].drive(shaft.as_ref(), before[motor]);
            self.drive(self.robot.shafts[motor].handle, drive);
        }
        self.world.step();
        self.step += 1;
        self.rates = self.robot.shafts.map(|shaft| shaft.rate(&self.world));
        self.observe();
        let seat = &self.world.bodies[self.robot.bodies[SEAT]];
        let heading = self.truth.yaw - self.parameters.initial_heading;
        self.sensing
            .update(&self.parameters.body_sensors, seat, heading, self.step);
    }

    fn drive(&mut self, handle: ImpulseJointHandle, drive: Drive) {
        // The handle lives as long as the world does.
        if let Some(joint) = self.world.impulse_joints.get_mut(handle, false) {
            let [stiffness, damping] = drive.stiffness;
            let axis = JointAxis::AngX;
            joint
                .data
                .set_motor(axis, drive.place, drive.speed, stiffness, damping);
            joint.data.set_motor_max_force(axis, drive.limit);
        }
    }

    /// What the board of motor `motor` senses after the last step.
    ///
    /// # Panics
    /// If `motor` is not below [`MOTORS`].
    pub fn sensors(&self, motor: usize) -> Sensors {
        let joint = self
            .world
            .impulse_joints
            .get(self.robot.shafts[motor].handle);
        let passed_on = joint
            .and_then(|joint| joint.data.motor(JointAxis::AngX))
            .map_or(0.0, |motor| -motor.impulse * SUBSTEPS as f64 / DT);
        Sensors {
            encoder_frozen: false,
            shaft_torque: self.gears[motor].shaft_torque(passed_on, self.rates[motor]) as f32,
            bus_voltage: self.parameters.bus_voltage as f32,
            switches: Switches::default(),
            body: None,
        }
    }

    /// What the sensors on the seat say after the last step.
    pub fn body_sensors(&self) -> BodySensors {
        self.sensing.reading()
    }

    /// What the physics knows after the last step.
    pub fn truth(&self) -> &RtMoverTruth {
        &self.truth
    }

    /// Angles of all joints, in the order of the motors, rad; the wheels' from -pi to pi.
    pub fn joints(&self) -> [f64; MOTORS] {
        self.robot.shafts.map(|shaft| shaft.angle(&self.world))
    }

    /// Weight, N.
    pub fn weight(&self) -> f64 {
        self.parameters.masses.total() * GRAVITY
    }

    /// Hands over every bit of the physical state, in a fixed order.
    pub fn truth_bits(&self, sink: &mut dyn FnMut(&[u8])) {
        let mut put = |value: f64| sink(&value.to_bits().to_le_bytes());
        for handle in self.robot.bodies {
            let body = &self.world.bodies[handle];
            body.position()
                .rotation
                .to_array()
                .into_iter()
                .for_each(&mut put);
            for vector in [body.position().translation, body.linvel(), body.angvel()] {
                vector.to_array().into_iter().for_each(&mut put);
            }
        }
        for vector in self.sensing.state() {
            vector.to_array().into_iter().for_each(&mut put);
        }
    }

    fn observe(&mut self) {
        let bodies = self.robot.bodies.map(|handle| &self.world.bodies[handle]);
        let m = &self.parameters.masses;
        let seat_centre = Vector::new(m.seat_forward, 0.0, m.seat_height);
        let masses = [
            m.body,
            m.seat,
            0.5 * m.arm,
            0.5 * m.arm,
            0.5 * m.arm,
            0.5 * m.arm,
            m.wheel,
            m.wheel,
            m.wheel,
            m.wheel,
        ];
        let mut moment = Vector::ZERO;
        for (index, (body, mass)) in bodies.iter().zip(masses).enumerate() {
            let local = if index == SEAT {
                seat_centre
            } else {
                Vector::ZERO
            };
            moment += body.position().transform_point(local) * mass;
        }
        let tilt = |body: &RigidBody| {
            let [forward, left] =
                [Vector::X, Vector::Y].map(|axis| body.position().rotation * axis);
            let level = libm::sqrt(left.x * left.x + left.y * left.y);
            let ahead = libm::sqrt(forward.x * forward.x + forward.y * forward.y);
            [libm::atan2(forward.z, ahead), libm::atan2(left.z, level)]
        };
        let truth = &mut self.truth;
        truth.middle = bodies[0].position().translation.to_array();
        truth.seat = tilt(bodies[SEAT]);
        let forward = bodies[0].position().rotation * Vector::X;
        truth.yaw = libm::atan2(forward.y, forward.x);
        truth.cog = (moment / m.total()).to_array();
        truth.wheels = self
            .robot
            .lowest_points(&self.world, &self.parameters)
            .map(|point| point.to_array());
        truth.loads = [0.0; 4];
        for pair in self.world.contact_pairs() {
            let wheel = |handle| self.robot.wheels.iter().position(|own| *own == handle);
            let (wheel, sign) = match (wheel(pair.collider1), wheel(pair.collider2)) {
                (Some(wheel), _) => (wheel, -1.0),
                (_, Some(wheel)) => (wheel, 1.0),
                _ => continue,
            };
            for manifold in pair.solver_manifolds() {
                let up = manifold.data.normal.z * sign;
                let impulse: f64 = manifold.points.iter().map(|point| point.data.impulse).sum();
                truth.loads[wheel] += up * impulse / DT;
            }
        }
        truth.toppled |= truth.seat.iter().any(|angle| angle.abs() > TURNED_OVER);
    }
}
