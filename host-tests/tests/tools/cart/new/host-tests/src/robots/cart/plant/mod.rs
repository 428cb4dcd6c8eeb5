//! Simulates the cart on flat ground and slopes.
//!
//! `robot` has bodies and joints in the physics engine. This module has the order of one step, and
//! the ground truth.

mod robot;

use crate::world::Plant;
use crate::world::gear::Gear;
use crate::world::ground::Ground;
use crate::world::noise::Noise;
use crate::world::physics::{pose, turn, world};
use crate::world::sensing::{BodyMotion, BodySensing, BodySensorParameters};
use crate::world::truth::{BodyPose, BodyShape, Part, Sketch, Truth};
use core::f64::consts::TAU;
use rapier3d_f64::math::{Pose, Vector};
use rapier3d_f64::prelude::*;
use robot::{HALF_WIDTH, HEAD_RADIUS, Robot};
use tautrack::link::{BodyMeasurands, Sensors, Shaft};
use tautrack::robots::cart::parameters::CART;

/// Damping of a wheel's gear, N m s/rad, and friction of a wheel without power, N m; assumed.
const GEAR: f64 = 2.0e3;
const DEAD_FRICTION: f64 = 1.0;
/// Supply voltage, V.
const BUS_VOLTAGE: f32 = 24.0;
/// Steps for which a contact counts after it last carried force, because single contacts flicker.
const WINDOW: u64 = 50;
/// The cart has turned over when the cosine of its angle to the ground is below this.
const TURNED_OVER: f64 = 0.5;
const SENSORS: BodySensorParameters = BodySensorParameters {
    accelerometer_place: [0.0, 0.0, 0.1],
    ..BodySensorParameters::NOMINAL
};
/// Names of the wheels' channels, and of the bodies.
const RATES: [&str; 2] = ["left_wheel_radps", "right_wheel_radps"];
const BODIES: [&str; 3] = ["chassis", "left_wheel", "right_wheel"];

/// The cart on its ground.
pub struct Cart {
    world: PhysicsWorld,
    robot: Robot,
    gears: [Gear; 2],
    sensing: BodySensing,
    step: u64,
    mast: f64,
    ground: Ground,
    /// Normal of the ground.
    up: Vector,
    carrying_until: [u64; 3],
    truth: Truth,
}

impl Cart {
    /// Puts the cart at the origin, with the head of the mast at height `mast`, m. `seed` is the
    /// one of the sensors.
    pub fn new(mast: f64, friction: f64, ground: &Ground, seed: u64) -> Self {
        let mut world = world();
        let [pitch, roll] = ground.inclination();
        let tilt = Pose::from_rotation(turn(Vector::NEG_Y, pitch) * turn(Vector::X, roll));
        for block in ground.blocks() {
            let [x, y, z] = block.half;
            let place = Pose::from_translation(Vector::from_array(block.centre));
            world.insert_collider(
                ColliderBuilder::cuboid(x, y, z)
                    .position(tilt * place)
                    .friction(friction),
                None,
            );
        }
        let robot = Robot::build(&mut world, mast, friction, tilt);
        let mut plant = Self {
            gears: [Gear::new([0.0, GEAR], TAU, Some(DEAD_FRICTION), 0.0); 2],
            sensing: BodySensing::new(&SENSORS, Noise::new(seed), tilt.rotation),
            step: 0,
            mast,
            ground: *ground,
            up: tilt.rotation * Vector::Z,
            carrying_until: [0; 3],
            truth: Truth::default(),
            world,
            robot,
        };
        plant.observe();
        plant
    }

    /// Updates the ground truth.
    fn observe(&mut self) {
        let (world, robot) = (&self.world, &self.robot);
        let chassis = &world.bodies[robot.chassis];
        let at = |x: f64, z: f64| chassis.position().transform_point(Vector::new(x, 0.0, z));
        let [forward, left, upright] =
            [Vector::X, Vector::Y, Vector::Z].map(|axis| chassis.position().rotation * axis);
        let heading = left.cross(Vector::Z).normalize_or_zero();
        let [behind, up] = CART.cog(self.mast);
        let cog = at(-behind, up);
        let truth = &mut self.truth;
        truth.pitch = libm::atan2(forward.dot(heading.cross(left)), forward.dot(heading));
        truth.roll = libm::atan2(left.z, libm::sqrt(left.x * left.x + left.y * left.y));
        truth.yaw = libm::atan2(heading.y, heading.x);
        truth.pitch_rate = -chassis.angvel().dot(left);
        truth.axle_1 = at(0.0, CART.wheel_radius).to_array();
        truth.cog = cog.to_array();
        truth.ground_speed = chassis.velocity_at_point(at(0.0, 0.0)).dot(heading);
        for (until, carries) in self.carrying_until.iter_mut().zip(robot.carrying(world)) {
            if carries {
                *until = self.step + WINDOW;
            }
        }
        let lowest = robot.lowest(world, self.up);
        let carrying = lowest.iter().zip(self.carrying_until);
        let contacts: Vec<Vector> = carrying
            .filter(|(_, until)| *until > self.step)
            .map(|(place, _)| *place)
            .collect();
        let along = contacts.iter().map(|place| (*place - cog).dot(heading));
        truth.backward_margin = along.clone().map(|along| -along).reduce(f64::max);
        truth.forward_margin = along.reduce(f64::max);
        truth.contacts = contacts.iter().map(Vector::to_array).collect();
        truth.toppled |= upright.dot(self.up) < TURNED_OVER;
        for (side, name) in RATES.into_iter().enumerate() {
            truth.channels.insert(name, robot.rate(world, side));
        }
        let [left, right] = robot
            .wheels
            .map(|wheel| world.bodies[wheel].position().translation);
        let chassis = at(-CART.behind, CART.chassis_height);
        truth.points = [left, right, lowest[2], chassis, at(-CART.behind, self.mast)]
            .map(|place| place.to_array())
            .to_vec();
    }
}

impl Plant for Cart {
    fn step(&mut self, shafts: &[Option<Shaft>]) {
        for (side, gear) in self.gears.iter_mut().enumerate() {
            let shaft = shafts.get(side).and_then(Option::as_ref);
            // A gear without stiffness does not use the position.
            let drive = gear.drive(shaft, 0.0);
            self.robot.drive(&mut self.world, side, drive);
        }
        self.world.step();
        self.step += 1;
        self.observe();
        let motion = BodyMotion::of(&self.world.bodies[self.robot.chassis], &SENSORS);
        self.sensing.update(&SENSORS, &motion, self.step);
    }

    fn sensors(&self, motor: usize) -> Sensors {
        let force = self.robot.passed_on(&self.world, motor);
        let rate = self.robot.rate(&self.world, motor);
        Sensors {
            shaft_torque: self.gears[motor].shaft_torque(force, rate) as f32,
            supply_voltage: BUS_VOLTAGE,
            ..Sensors::default()
        }
    }

    fn body_sensors(&self) -> BodyMeasurands {
        self.sensing.reading()
    }

    /// The wheels, the triangle of contacts, and the mast.
    fn sketch(&self) -> Sketch {
        Sketch {
            circles: vec![
                (0, CART.wheel_radius),
                (1, CART.wheel_radius),
                (4, HEAD_RADIUS),
            ],
            lines: vec![vec![0, 1, 2, 0], vec![3, 4]],
        }
    }

    fn bodies(&self) -> Vec<BodyShape> {
        let chassis = Part::Box {
            centre: [-CART.behind, 0.0, CART.chassis_height],
            size: CART.chassis_size,
        };
        let head = Part::Box {
            centre: [-CART.behind, 0.0, self.mast],
            size: [2.0 * HEAD_RADIUS; 3],
        };
        let wheel = Part::Wheel {
            centre: [0.0; 3],
            radius: CART.wheel_radius,
            width: 2.0 * HALF_WIDTH,
        };
        BODIES
            .into_iter()
            .zip([vec![chassis, head], vec![wheel], vec![wheel]])
            .map(|(name, parts)| BodyShape { name, parts })
            .collect()
    }

    fn poses(&self) -> Vec<BodyPose> {
        let bodies = self.bodies_in_order();
        bodies.map(pose).to_vec()
    }

    fn ground_height(&self, place: [f64; 2]) -> f64 {
        self.ground.height(place, self.up.to_array())
    }

    fn truth(&self) -> &Truth {
        &self.truth
    }

    fn truth_bits(&self, sink: &mut dyn FnMut(&[u8])) {
        let mut put = |value: f64| sink(&value.to_bits().to_le_bytes());
        for body in self.bodies_in_order() {
            let pose = body.position();
            pose.rotation.to_array().into_iter().for_each(&mut put);
            for vector in [pose.translation, body.linvel(), body.angvel()] {
                vector.to_array().into_iter().for_each(&mut put);
            }
        }
        self.sensing.bits(&mut put);
    }
}

impl Cart {
    fn bodies_in_order(&self) -> [&RigidBody; 3] {
        let [left, right] = self.robot.wheels;
        [self.robot.chassis, left, right].map(|handle| &self.world.bodies[handle])
    }
}
