//! The wheel-legged robot of Besseron et al.: a platform on four legs, each with a steered and driven wheel, sixteen motors in all.
//!
//! [`parameters`]: the constant model. [`hillside`]: the ground. `robot`: bodies and joints in the physics engine. `truth`: what the physics
//! knows. Here: the sixteen gears and the order of one step.

pub mod hillside;
pub mod parameters;
mod robot;
mod truth;

pub use hillside::Hillside;
pub use parameters::HylosParameters;
pub use truth::Detail;

use crate::plant::Plant;
use crate::plant::gear::{Drive, Gear};
use crate::plant::noise::Noise;
use crate::plant::sensing::{BodyMotion, BodySensing};
use crate::plant::world::{pose, world};
use crate::record::{BodyPose, BodyShape, Part, Sketch, Truth};
use core::f64::consts::TAU;
use rapier3d_f64::math::Vector;
use rapier3d_f64::prelude::*;
use robot::Robot;
use tautrack::link::{BodySensors, Sensors, Shaft, Switches};
use tautrack::robots::hylos::LEGS;
use tautrack::robots::hylos::parameters::{HIP_RANGE, KNEE_RANGE, STEERING_RANGE};

/// Motors in the order of their nodes: hip, knee, steering and wheel of the front left leg, then front right, rear left, rear right.
pub const MOTORS: usize = 4 * LEGS;
/// Hip, knee, steering and wheel within a leg.
const HIP: usize = 0;
const KNEE: usize = 1;
const STEERING: usize = 2;
const WHEEL: usize = 3;

/// Names of the bodies that a picture shows: the platform, and the wheels in the order of the legs.
const BODIES: [&str; 1 + LEGS] = [
    "platform",
    "front_left_wheel",
    "front_right_wheel",
    "rear_left_wheel",
    "rear_right_wheel",
];
/// Height of the platform and width of the tyres in a picture, m: the paper gives neither.
const PLATFORM_HEIGHT: f64 = 0.06;
const TYRE_WIDTH: f64 = 0.05;

/// Hylos on its ground.
pub struct Hylos {
    parameters: HylosParameters,
    hillside: Hillside,
    world: PhysicsWorld,
    robot: Robot,
    /// Hip, knee and steering of each leg.
    gears: [[Gear; 3]; LEGS],
    /// Wheels whose node is alive.
    driven: [bool; LEGS],
    /// Torques that the gears of hips and knees passed on in the last step, N m.
    leg_torques: [[f64; 2]; LEGS],
    standing_until: [u64; LEGS],
    body_sensing: BodySensing,
    step: u64,
    truth: Truth,
    detail: Detail,
}

impl Hylos {
    /// The robot where its parameters put it; `seed` is that of the sensors' noise.
    pub fn new(parameters: &HylosParameters, hillside: &Hillside, seed: u64) -> Self {
        let p = *parameters;
        let mut world = world();
        world.insert_collider(hillside.collider(p.friction), None);
        let below = [p.start[0], p.start[1]];
        let robot = Robot::build(
            &mut world,
            &p,
            hillside.height(below),
            Vector::from_array(hillside.normal(below)),
        );
        // The gear's own stiffness is the leg's, which acts at the wheel.
        let leg = |place| Gear::new([0.0; 2], TAU, None, place);
        let steering = || Gear::new(p.steering_gear, TAU, Some(p.dead_friction[0]), 0.0);
        let body_sensing = BodySensing::new(
            &p.body_sensors,
            Noise::new(seed),
            world.bodies[robot.platform].position().rotation,
        );
        let mut plant = Self {
            gears: core::array::from_fn(|_| {
                [leg(p.initial_leg[0]), leg(p.initial_leg[1]), steering()]
            }),
            driven: [false; LEGS],
            leg_torques: [[0.0; 2]; LEGS],
            standing_until: [0; LEGS],
            body_sensing,
            step: 0,
            truth: Truth::default(),
            detail: Detail::default(),
            hillside: *hillside,
            parameters: p,
            world,
            robot,
        };
        plant.observe();
        plant
    }

    /// What the physics knows of the legs after the last step; no node may see it.
    pub fn detail(&self) -> &Detail {
        &self.detail
    }

    fn drive_leg(&mut self, leg: usize, shafts: &[Option<Shaft>; 4]) {
        let p = &self.parameters;
        let joints = p.joints(self.robot.reach(&self.world, p, leg));
        let steering = self.robot.steering(&self.world, leg);
        let [hip, knee, steer] = &mut self.gears[leg];
        let hip = hip.drive(shafts[HIP].as_ref(), joints[0]);
        let knee = knee.drive(shafts[KNEE].as_ref(), joints[1]);
        let steer = steer.drive(shafts[STEERING].as_ref(), steering);
        let wheel = shafts[WHEEL].as_ref();
        self.driven[leg] = wheel.is_some();

        let [reach, below] = p.reach([hip.place, knee.place]);
        let [[hip_x, hip_z], [knee_x, knee_z]] = columns(p, [hip.place, knee.place]);
        let slide = |place: f64, speed: f64| Drive {
            place,
            speed,
            stiffness: p.leg_gear,
            limit: f64::MAX,
        };
        let front = robot::forward(leg);
        let forward = slide(
            front * reach,
            front * (hip_x * hip.speed + knee_x * knee.speed),
        );
        let upward = slide(-below, hip_z * hip.speed + knee_z * knee.speed);
        let roll = Drive {
            place: 0.0,
            speed: wheel.map_or(0.0, |shaft| f64::from(shaft.velocity)),
            stiffness: [0.0, p.wheel_gear],
            limit: wheel.map_or(p.dead_friction[1], |_| f64::MAX),
        };
        for (joint, axis, drive) in [
            (self.robot.legs[leg], JointAxis::LinX, upward),
            (self.robot.legs[leg], JointAxis::LinY, forward),
            (self.robot.legs[leg], JointAxis::AngX, steer),
            (self.robot.axles[leg], JointAxis::AngX, roll),
        ] {
            // The handle lives as long as the world does.
            if let Some(joint) = self.world.impulse_joints.get_mut(joint, false) {
                let [stiffness, damping] = drive.stiffness;
                joint
                    .data
                    .set_motor(axis, drive.place, drive.speed, stiffness, damping);
                joint.data.set_motor_max_force(axis, drive.limit);
            }
        }
    }

    /// Torques of hip and knee that hold the force at the wheel: its work is theirs.
    fn torques(&self, leg: usize) -> [f64; 2] {
        let joint = self.robot.legs[leg];
        let upward = Robot::passed_on(&self.world, joint, JointAxis::LinX);
        let outward = robot::forward(leg) * Robot::passed_on(&self.world, joint, JointAxis::LinY);
        let p = &self.parameters;
        let joints = p.joints(self.robot.reach(&self.world, p, leg));
        columns(p, joints).map(|[x, z]| x * outward + z * upward)
    }
}

impl Plant for Hylos {
    fn step(&mut self, shafts: &[Option<Shaft>]) {
        let (legs, _) = shafts.as_chunks::<4>();
        assert_eq!(
            (legs.len(), shafts.len()),
            (LEGS, MOTORS),
            "one shaft for each motor"
        );
        for (leg, shafts) in legs.iter().enumerate() {
            self.drive_leg(leg, shafts);
        }
        self.world.step();
        self.step += 1;
        for leg in 0..LEGS {
            self.leg_torques[leg] = self.torques(leg);
        }
        self.observe();
        let sensors = &self.parameters.body_sensors;
        let motion = BodyMotion::of(&self.world.bodies[self.robot.platform], sensors);
        self.body_sensing.update(sensors, &motion, self.step);
    }

    /// The reference switch of a joint is at its edge when the robot just stands.
    fn sensors(&self, motor: usize) -> Sensors {
        assert!(
            motor < MOTORS,
            "Hylos has {MOTORS} motors, there is no motor {motor}"
        );
        let p = &self.parameters;
        let (leg, kind) = (motor / 4, motor % 4);
        let (joint, gear) = (self.robot.legs[leg], &self.gears[leg]);
        let torque = match kind {
            HIP | KNEE => gear[kind].shaft_torque(self.leg_torques[leg][kind], 0.0),
            STEERING => {
                gear[kind].shaft_torque(Robot::passed_on(&self.world, joint, JointAxis::AngX), 0.0)
            }
            _ if self.driven[leg] => {
                Robot::passed_on(&self.world, self.robot.axles[leg], JointAxis::AngX)
            }
            _ => 0.0,
        };
        let detail = &self.detail;
        let (place, range, reference) = match kind {
            HIP => (detail.legs[leg][0], HIP_RANGE, p.initial_leg[0]),
            KNEE => (detail.legs[leg][1], KNEE_RANGE, p.initial_leg[1]),
            _ => (detail.steering[leg], STEERING_RANGE, 0.0),
        };
        let switches = if kind == WHEEL {
            Switches::default()
        } else {
            Switches {
                reference: place <= reference,
                positive_limit: place >= range[1],
                negative_limit: place <= range[0],
            }
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

    /// Wheels, legs, and the platform as the line through its hips.
    fn sketch(&self) -> Sketch {
        let p = &self.parameters;
        let mut lines: Vec<_> = (0..LEGS)
            .map(|leg| (3 * leg..3 * leg + 3).collect())
            .collect();
        lines.push([0, 1, 3, 2, 0].map(|leg| 3 * leg).to_vec());
        Sketch {
            circles: (0..LEGS)
                .map(|leg| (3 * leg + 2, p.measures.wheel_radius))
                .collect(),
            lines,
        }
    }

    fn bodies(&self) -> Vec<BodyShape> {
        let m = &self.parameters.measures;
        let platform = Part::Box {
            centre: [0.0; 3],
            size: [2.0 * m.hip[0], 2.0 * m.hip[1], PLATFORM_HEIGHT],
        };
        let wheel = Part::Wheel {
            centre: [0.0; 3],
            radius: m.wheel_radius,
            width: TYRE_WIDTH,
        };
        let parts = std::iter::once(platform).chain([wheel; LEGS]);
        BODIES
            .into_iter()
            .zip(parts)
            .map(|(name, part)| BodyShape {
                name,
                parts: vec![part],
            })
            .collect()
    }

    fn poses(&self) -> Vec<BodyPose> {
        std::iter::once(self.robot.platform)
            .chain(self.robot.wheels)
            .map(|handle| pose(&self.world.bodies[handle]))
            .collect()
    }

    fn ground_height(&self, place: [f64; 2]) -> f64 {
        self.hillside.height(place)
    }

    fn truth(&self) -> &Truth {
        &self.truth
    }

    fn truth_bits(&self, sink: &mut dyn FnMut(&[u8])) {
        let mut put = |value: f64| sink(&value.to_bits().to_le_bytes());
        let handles = [self.robot.platform]
            .into_iter()
            .chain(self.robot.carriers)
            .chain(self.robot.wheels);
        for handle in handles {
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
        self.leg_torques
            .as_flattened()
            .iter()
            .copied()
            .for_each(&mut put);
        self.body_sensing.bits(&mut put);
    }
}

/// What hip and knee do to the wheel's centre: forward (backward at the rear) and up.
fn columns(p: &HylosParameters, [hip, knee]: [f64; 2]) -> [[f64; 2]; 2] {
    let [thigh, shank] = p.measures.leg;
    let (sine, cosine) = (libm::sin(hip + knee), libm::cos(hip + knee));
    let by_knee = [-shank * sine, -shank * cosine];
    [
        [
            by_knee[0] - thigh * libm::sin(hip),
            by_knee[1] - thigh * libm::cos(hip),
        ],
        by_knee,
    ]
}
