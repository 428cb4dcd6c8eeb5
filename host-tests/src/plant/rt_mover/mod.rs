//! RT-Mover of Nakajima: body, seat on its pitch shaft, two arms that steer and roll, four wheels; nine motors.
//!
//! [`parameters`]: the constant model. `robot`: bodies and joints in the physics engine. Here: the order of one step.

pub mod parameters;
mod robot;

pub use parameters::RtMoverParameters;
pub use robot::MOTORS;

use crate::plant::Plant;
use crate::plant::b2p2::Payload;
use crate::plant::gear::{Drive, Gear};
use crate::plant::noise::Noise;
use crate::plant::sensing::{BodyMotion, BodySensing};
use crate::plant::terrain::Terrain;
use crate::plant::world::{DT, GRAVITY, SUBSTEPS, pose, turn, world};
use crate::record::{BodyPose, BodyShape, Sketch, Truth};
use core::f64::consts::TAU;
use rapier3d_f64::math::{Pose, Vector};
use rapier3d_f64::prelude::*;
use robot::{Robot, SEAT};
use tautrack::link::{BodySensors, Sensors, Shaft, Switches};

/// Channels of [`Truth`] that only this robot has, wheel by wheel: force of the ground upward, and height of the lowest point.
const LOADS: [&str; 4] = [
    "front_left_load_n",
    "front_right_load_n",
    "rear_left_load_n",
    "rear_right_load_n",
];
const HEIGHTS: [&str; 4] = [
    "front_left_height_m",
    "front_right_height_m",
    "rear_left_height_m",
    "rear_right_height_m",
];
/// How far ahead of the robot's start that point is.
const PLACES: [&str; 4] = [
    "front_left_x_m",
    "front_right_x_m",
    "rear_left_x_m",
    "rear_right_x_m",
];
/// Angles of the shafts behind the wheels' motors.
const SHAFTS: [&str; 5] = [
    "front_steering_rad",
    "rear_steering_rad",
    "front_roll_rad",
    "rear_roll_rad",
    "pitch_shaft_rad",
];
/// Least distance of the centre of gravity to the edges between the wheels that carry load; absent in free flight.
const MARGIN: &str = "support_margin_m";
/// Around the robot from above, counter-clockwise.
const AROUND: [usize; 4] = [3, 1, 0, 2];

/// RT-Mover on its ground.
pub struct RtMover {
    parameters: RtMoverParameters,
    world: PhysicsWorld,
    robot: Robot,
    gears: [Gear; MOTORS],
    rates: [f64; MOTORS],
    sensing: BodySensing,
    step: u64,
    terrain: Terrain,
    /// Normal of the whole ground.
    up: [f64; 3],
    lowest: [Vector; 4],
    loads: [f64; 4],
    standing_until: [u64; 4],
    payload: Option<Payload>,
    truth: Truth,
}

/// Tilt of the seat from which the robot counts as turned over, rad.
const TURNED_OVER: f64 = 1.0;
/// How long a wheel that carried force counts as standing, steps: single contacts flicker.
const WINDOW: u64 = 50;
/// Below this a wheel supports nothing, N.
const LEAST_LOAD: f64 = 0.1;
/// Motors before this one turn wheels.
const WHEELS: usize = 4;
/// Angle from which a shaft's reference switch is closed, rad: close to where it stands on level ground, so that no wheel leaves it for that.
pub const SWITCH: f64 = 0.01;

impl RtMover {
    /// The robot at the origin of `terrain`; `seed` is that of the sensors' noise.
    pub fn new(parameters: &RtMoverParameters, terrain: &Terrain, seed: u64) -> Self {
        let p = *parameters;
        let mut world = world();
        let [pitch, roll] = terrain.inclination();
        let tilt = Pose::from_rotation(turn(Vector::NEG_Y, pitch) * turn(Vector::X, roll));
        for block in terrain.blocks() {
            let [x, y, z] = block.half;
            let lie = Pose::from_parts(
                Vector::from_array(block.centre),
                turn(Vector::NEG_Y, block.pitch),
            );
            world.insert_collider(
                ColliderBuilder::cuboid(x, y, z)
                    .position(tilt * lie)
                    .friction(p.friction),
                None,
            );
        }
        let robot = Robot::build(&mut world, &p, tilt);
        let seat = &world.bodies[robot.bodies[SEAT]];
        let sensing = BodySensing::new(&p.body_sensors, Noise::new(seed), seat.position().rotation);
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
            terrain: *terrain,
            up: (tilt.rotation * Vector::Z).to_array(),
            lowest: [Vector::ZERO; 4],
            loads: [0.0; 4],
            standing_until: [0; 4],
            payload: None,
            truth: Truth::default(),
            parameters: p,
            world,
            robot,
            sensing,
        };
        plant.observe();
        plant
    }

    fn put_payload_on(&mut self) {
        let due = self
            .parameters
            .payload
            .filter(|payload| self.step as f64 * DT >= payload.from_time_s);
        if let (None, Some(load)) = (self.payload, due) {
            self.payload = due;
            let properties = robot::seat(&self.parameters)
                + MassProperties::new(
                    Vector::from_array(load.place),
                    load.mass,
                    Vector::splat(load.own_inertia()),
                );
            let seat = &mut self.world.bodies[self.robot.bodies[SEAT]];
            seat.set_additional_mass_properties(properties, true);
        }
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

    /// Lowest points of the wheels, m.
    pub fn wheels(&self) -> [[f64; 3]; 4] {
        self.lowest.map(|point| point.to_array())
    }

    /// Upward force of the ground on each wheel in the last step, N.
    pub fn loads(&self) -> [f64; 4] {
        self.loads
    }

    /// Angles of all joints, in the order of the motors, rad; the wheels' from -pi to pi.
    pub fn joints(&self) -> [f64; MOTORS] {
        self.robot.shafts.map(|shaft| shaft.angle(&self.world))
    }

    /// Weight, N.
    pub fn weight(&self) -> f64 {
        let load = self.payload.map_or(0.0, |load| load.mass);
        (self.parameters.masses.total() + load) * GRAVITY
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
        let load = self.payload.map_or(0.0, |load| {
            let place = Vector::from_array(load.place);
            moment += bodies[SEAT].position().transform_point(place) * load.mass;
            load.mass
        });
        let [forward, left] =
            [Vector::X, Vector::Y].map(|axis| bodies[SEAT].position().rotation * axis);
        let points = self.robot.points(&self.world, &self.parameters);
        self.lowest = self.robot.lowest_points(&self.world, &self.parameters);
        self.loads = self.robot.loads(&self.world);
        let shafts = self.robot.shafts.map(|shaft| shaft.angle(&self.world));
        let truth = &mut self.truth;
        [truth.pitch, truth.roll] = tilt(bodies[SEAT]);
        truth.pitch_rate = -bodies[SEAT].angvel().dot(left);
        truth.yaw = libm::atan2(forward.y, forward.x);
        truth.axle_1 = (0.5 * (points[2] + points[3])).to_array();
        truth.cog = (moment / (m.total() + load)).to_array();
        truth.ground_speed = bodies[0].linvel().dot(forward);
        truth.contacts.clear();
        for (until, load) in self.standing_until.iter_mut().zip(self.loads) {
            if load > LEAST_LOAD {
                *until = self.step + WINDOW;
            }
        }
        let stands = self.standing_until.map(|until| until > self.step);
        for (wheel, (place, load)) in self.lowest.iter().zip(self.loads).enumerate() {
            truth.channels.insert(LOADS[wheel], load);
            truth.channels.insert(HEIGHTS[wheel], place.z);
            truth.channels.insert(PLACES[wheel], place.x);
            if stands[wheel] {
                truth.contacts.push(place.to_array());
            }
        }
        for (name, angle) in SHAFTS.into_iter().zip(&shafts[4..]) {
            truth.channels.insert(name, *angle);
        }
        let standing: Vec<_> = AROUND
            .into_iter()
            .filter(|wheel| stands[*wheel])
            .map(|wheel| self.lowest[wheel])
            .collect();
        match margin(&standing, Vector::from_array(truth.cog)) {
            Some(margin) => truth.channels.insert(MARGIN, margin),
            None => truth.channels.remove(MARGIN),
        };
        truth.points.clear();
        truth.points.extend(points.iter().map(Vector::to_array));
        truth.toppled |= truth.pitch.abs() > TURNED_OVER || truth.roll.abs() > TURNED_OVER;
    }
}

/// Least horizontal distance of `cog` to the edges of a support that runs counter-clockwise, positive inside, m. Two corners support a
/// line and one a point, on which nothing is inside; without any there is no support.
fn margin(corners: &[Vector], cog: Vector) -> Option<f64> {
    let level = |vector: Vector| Vector::new(vector.x, vector.y, 0.0);
    let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
    let edges = pairs.map(|(from, to)| [level(*to - *from), level(cog - *from)]);
    match corners {
        [] => None,
        [point] => Some(-level(cog - *point).length()),
        [_, _] => edges
            .map(|[edge, offset]| {
                let share = offset.dot(edge) / edge.length_squared();
                -(offset - edge * share.clamp(0.0, 1.0)).length()
            })
            .reduce(f64::max),
        _ => edges
            .map(|[edge, offset]| (edge.x * offset.y - edge.y * offset.x) / edge.length())
            .reduce(f64::min),
    }
}

impl Plant for RtMover {
    fn step(&mut self, shafts: &[Option<Shaft>]) {
        self.put_payload_on();
        let before = self.robot.shafts.map(|shaft| shaft.angle(&self.world));
        for (motor, place) in before.into_iter().enumerate() {
            let shaft = shafts.get(motor).and_then(Option::as_ref);
            let drive = self.gears[motor].drive(shaft, place);
            self.drive(self.robot.shafts[motor].handle, drive);
        }
        self.world.step();
        self.step += 1;
        self.rates = self.robot.shafts.map(|shaft| shaft.rate(&self.world));
        self.observe();
        let p = &self.parameters.body_sensors;
        let seat = BodyMotion::of(&self.world.bodies[self.robot.bodies[SEAT]], p);
        self.sensing.update(p, &seat, self.step);
    }

    fn sensors(&self, motor: usize) -> Sensors {
        let joint = self
            .world
            .impulse_joints
            .get(self.robot.shafts[motor].handle);
        let passed_on = joint
            .and_then(|joint| joint.data.motor(JointAxis::AngX))
            .map_or(0.0, |motor| -motor.impulse * SUBSTEPS as f64 / DT);
        let angle = self.robot.shafts[motor].angle(&self.world);
        Sensors {
            switches: Switches {
                reference: motor >= WHEELS && angle >= SWITCH,
                ..Switches::default()
            },
            shaft_torque: self.gears[motor].shaft_torque(passed_on, self.rates[motor]) as f32,
            bus_voltage: self.parameters.bus_voltage as f32,
            ..Sensors::default()
        }
    }

    fn body_sensors(&self) -> BodySensors {
        self.sensing.reading()
    }

    fn sketch(&self) -> Sketch {
        let radius = self.parameters.lengths.wheel_radius;
        Sketch {
            circles: (0..4).map(|wheel| (wheel, radius)).collect(),
            lines: vec![vec![0, 4, 1], vec![2, 5, 3], vec![4, 6, 5], vec![6, 7]],
        }
    }

    fn bodies(&self) -> Vec<BodyShape> {
        robot::shapes(&self.parameters)
    }

    fn poses(&self) -> Vec<BodyPose> {
        let bodies = self.robot.bodies.map(|handle| &self.world.bodies[handle]);
        bodies.map(pose).to_vec()
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
        self.sensing.bits(&mut put);
    }
}
