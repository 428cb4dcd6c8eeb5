//! The tracked robot of Paillat et al.: three segments, a chassis joint, a driving screw and a pair of belts.
//!
//! [`parameters`]: the constant model. `robot`: bodies and joints in the physics engine. `contact`: belts and ground. Here: the order of one step.

mod contact;
pub mod parameters;
mod robot;
mod truth;

pub use parameters::{B2p2Parameters, Payload};

use crate::plant::Plant;
use crate::plant::gear::{Belt, Drive, Gear};
use crate::plant::noise::Noise;
use crate::plant::receiver::Receiver;
use crate::plant::sensing::{BodyMotion, BodySensing};
use crate::plant::terrain::Terrain;
use crate::plant::world::{self, DT, SUBSTEPS};
use crate::record::{BodyPose, BodyShape, Part, Truth};
use contact::{GroundForces, RunningBelts, Support};
use core::f64::consts::TAU;
use rapier3d_f64::math::{Rotation, Vector};
use rapier3d_f64::prelude::*;
use robot::Robot;
use tautrack::link::{BodySensors, Sensors, Shaft, Switches};

/// B2P2 on its ground.
pub struct B2p2 {
    parameters: B2p2Parameters,
    world: PhysicsWorld,
    robot: Robot,
    belts: [Belt; 2],
    joint: Gear,
    screw: Gear,
    body_sensing: BodySensing,
    receiver: Receiver,
    support: Support,
    ground: GroundForces,
    /// Mean rates of chassis joint and screw in the last step, rad/s and m/s.
    rates: [f64; 2],
    step: u64,
    payload: Option<Payload>,
    terrain: Terrain,
    /// Normal of the whole ground.
    up: [f64; 3],
    truth: Truth,
}

impl B2p2 {
    /// The robot at the origin of `terrain`, shaped and placed as the parameters say; `seed` is that of the sensors' noise.
    pub fn new(parameters: &B2p2Parameters, terrain: &Terrain, seed: u64) -> Self {
        let p = *parameters;
        let mut world = world::world();
        let start = robot::lay_ground(&mut world, terrain, &p);
        let robot = Robot::build(&mut world, &p, start);
        let up = (start.rotation * Vector::Z).to_array();
        let body_sensing = BodySensing::new(
            &p.body_sensors,
            Noise::new(seed),
            world.bodies[robot.bodies[0]].position().rotation,
        );
        let mut plant = Self {
            joint: Gear::new(
                p.joint_gear,
                TAU,
                Some(p.dead_joint_friction),
                p.initial_theta,
            ),
            screw: Gear::new(p.screw_gear, p.screw_lead, None, p.initial_extension()),
            belts: [Belt::default(); 2],
            support: Support::default(),
            ground: GroundForces::default(),
            rates: [0.0; 2],
            receiver: Receiver::new(p.receiver, Noise::new(seed)),
            step: 0,
            payload: None,
            terrain: *terrain,
            up,
            truth: Truth::default(),
            parameters: p,
            world,
            robot,
            body_sensing,
        };
        plant.observe();
        plant
    }

    /// Sum of the ground's upward forces in the last step, N; the robot's weight when it is at rest.
    pub fn lift(&self) -> f64 {
        self.ground.lift
    }

    /// Kinetic and potential energy of the three segments, J; the potential is zero at z = 0.
    pub fn energy(&self) -> f64 {
        let bodies = self.robot.bodies.map(|handle| &self.world.bodies[handle]);
        bodies
            .iter()
            .map(|body| {
                body.kinetic_energy() + body.mass() * world::GRAVITY * body.center_of_mass().z
            })
            .sum()
    }

    fn put_payload_on(&mut self) {
        let due = self
            .parameters
            .payload
            .filter(|payload| self.step as f64 * DT >= payload.from_time_s);
        if self.payload.is_none() && due.is_some() {
            self.payload = due;
            let body = &mut self.world.bodies[self.robot.bodies[0]];
            body.set_additional_mass_properties(
                robot::mass_properties(&self.parameters, 0, due),
                true,
            );
        }
    }

    /// Force or torque that a gear passed on to its joint in the last substep, N or N m.
    ///
    /// The engine's impulse, not the spring law: after the engine's few iterations only the impulse balances the load.
    fn passed_on(&self, handle: ImpulseJointHandle, axis: JointAxis) -> f64 {
        let motor = self
            .world
            .impulse_joints
            .get(handle)
            .and_then(|joint| joint.data.motor(axis));
        motor.map_or(0.0, |motor| -motor.impulse * SUBSTEPS as f64 / DT)
    }

    fn drive_joint(&mut self, handle: ImpulseJointHandle, axis: JointAxis, drive: Drive) {
        // The handle lives as long as the world does.
        if let Some(joint) = self.world.impulse_joints.get_mut(handle, false) {
            let [stiffness, damping] = drive.stiffness;
            joint
                .data
                .set_motor(axis, drive.place, drive.speed, stiffness, damping);
            joint.data.set_motor_max_force(axis, drive.limit);
        }
    }
}

impl Plant for B2p2 {
    fn step(&mut self, shafts: &[Option<Shaft>]) {
        let p = self.parameters;
        let [left, right, joint, screw] =
            core::array::from_fn(|motor| shafts.get(motor).and_then(Option::as_ref));
        let [theta, _] = self.robot.chassis_joint(&self.world);
        let [extension, _] = self.robot.extension(&self.world, &p);
        self.put_payload_on();
        for (belt, shaft) in self.belts.iter_mut().zip([left, right]) {
            belt.drive(
                shaft,
                p.pulley_radius,
                p.track_inertia,
                p.dead_track_friction,
            );
        }
        self.robot.lay_chords(&mut self.world, &p, theta, extension);
        let (joint, screw) = (
            self.joint.drive(joint, theta),
            self.screw.drive(screw, extension),
        );
        self.drive_joint(self.robot.joint, JointAxis::AngX, joint);
        self.drive_joint(self.robot.screw, JointAxis::LinX, screw);

        let axle: Rotation = self.world.bodies[self.robot.bodies[0]].position().rotation;
        let running = RunningBelts {
            speed: self.belts.map(|belt| belt.surface_speed(p.belt_creep)),
            left: axle * Vector::Y,
        };
        self.world.step_with_events(&running, &());
        self.step += 1;
        let [now, _] = self.robot.chassis_joint(&self.world);
        let [length, _] = self.robot.extension(&self.world, &p);
        self.rates = [(now - theta) / DT, (length - extension) / DT];

        self.ground = contact::read(&self.world, &running, self.step, &mut self.support);
        for (side, belt) in self.belts.iter_mut().enumerate() {
            belt.load(
                self.ground.traction[side],
                self.ground.slip[side],
                p.belt_creep,
            );
        }
        self.observe();
        let body = &self.world.bodies[self.robot.bodies[0]];
        let motion = BodyMotion::of(body, &p.body_sensors);
        self.body_sensing
            .update(&p.body_sensors, &motion, self.step);
        let antenna = body
            .position()
            .transform_point(Vector::from_array(p.receiver.antenna));
        self.receiver.update(
            antenna.to_array(),
            body.velocity_at_point(antenna).to_array(),
            self.step,
        );
    }

    fn sensors(&self, motor: usize) -> Sensors {
        let p = &self.parameters;
        let [theta, _] = self.robot.chassis_joint(&self.world);
        let [extension, _] = self.robot.extension(&self.world, p);
        let limits = |place: f64, [low, high]: [f64; 2], reference: bool| Switches {
            reference,
            positive_limit: place >= high,
            negative_limit: place <= low,
        };
        let (torque, switches) = match motor {
            0 | 1 => (
                self.belts[motor].shaft_torque(p.pulley_radius),
                Switches::default(),
            ),
            2 => {
                let switches = limits(theta, p.joint_travel, theta >= p.joint_reference);
                (
                    self.joint.shaft_torque(
                        self.passed_on(self.robot.joint, JointAxis::AngX),
                        self.rates[0],
                    ),
                    switches,
                )
            }
            3 => {
                let switches = limits(extension, p.screw_travel, extension <= p.screw_reference);
                (
                    self.screw.shaft_torque(
                        self.passed_on(self.robot.screw, JointAxis::LinX),
                        self.rates[1],
                    ),
                    switches,
                )
            }
            _ => panic!("B2P2 has four motors, there is no motor {motor}"),
        };
        Sensors {
            encoder_frozen: false,
            shaft_torque: torque as f32,
            bus_voltage: p.bus_voltage as f32,
            switches,
            body: None,
        }
    }

    fn body_sensors(&self) -> BodySensors {
        self.body_sensing.reading()
    }

    fn serial(&self) -> &[u8] {
        self.receiver.sent()
    }

    fn bodies(&self) -> Vec<BodyShape> {
        let p = &self.parameters;
        let bar = |length: f64| Part::Box {
            centre: [0.5 * length, 0.0, 0.0],
            size: [length, p.width - 2.0 * p.belt_width, 0.6 * p.pulley_radius],
        };
        let pulley = |x: f64| Part::Wheel {
            centre: [x, 0.0, 0.0],
            radius: p.pulley_radius,
            width: p.width,
        };
        let body = |name, parts| BodyShape { name, parts };
        vec![
            body("body_1", vec![bar(p.l1), pulley(0.0), pulley(p.l1)]),
            body("body_2", vec![bar(p.l2)]),
            body("body_3", vec![pulley(0.0)]),
        ]
    }

    fn poses(&self) -> Vec<BodyPose> {
        let pose = |handle| world::pose(&self.world.bodies[handle]);
        self.robot.bodies.map(pose).to_vec()
    }

    fn ground_height(&self, place: [f64; 2]) -> f64 {
        self.terrain.height(place, self.up)
    }

    fn ground_edges(&self, from: [f64; 2], direction: [f64; 2]) -> Vec<f64> {
        self.terrain.edges(from, direction)
    }

    fn truth(&self) -> &Truth {
        &self.truth
    }

    fn truth_bits(&self, sink: &mut dyn FnMut(&[u8])) {
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
        for belt in &self.belts {
            [belt.speed, belt.traction, belt.slip_speed]
                .into_iter()
                .for_each(&mut put);
        }
        self.body_sensing.bits(&mut put);
        self.receiver.wander().into_iter().for_each(&mut put);
        put(self.truth.slip);
    }
}
