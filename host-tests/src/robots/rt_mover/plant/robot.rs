//! Bodies and joints of RT-Mover in the physics engine. Body axes are x forward, y left, z up;
//! those of all bodies are parallel at the start.

use super::parameters::RtMoverParameters;
use crate::world::inertia::Inertia;
use crate::world::physics::{DT, turn};
use crate::world::truth::{BodyShape, Part};
use rapier3d_f64::math::{Matrix, Pose, Vector};
use rapier3d_f64::prelude::*;

/// Number of motors. Their order is that of their nodes: four wheels, front and rear steering,
/// front and rear roll, pitch.
pub const MOTORS: usize = 9;
/// Fraction of an arm's mass that only steers and does not roll.
const YOKE: f64 = 0.5;
/// Moment of inertia added to that of an arm and of its yoke, kg m^2, for their struts. With
/// smaller inertias the solver's joints would be soft.
const STRUT: f64 = 0.02;

/// Joint of a motor: from one body to the next, positive about `axis`.
#[derive(Clone, Copy, Debug)]
pub struct Shafted {
    /// Handle of the joint in the engine.
    pub handle: ImpulseJointHandle,
    bodies: [RigidBodyHandle; 2],
    axis: Vector,
}

impl Shafted {
    /// Angle of the joint, rad, from -pi to pi.
    pub fn angle(&self, world: &PhysicsWorld) -> f64 {
        let [from, to] = self
            .bodies
            .map(|handle| world.bodies[handle].position().rotation);
        let relative = from.inverse() * to;
        let sine = Vector::new(relative.x, relative.y, relative.z).dot(self.axis);
        let angle = 2.0 * libm::atan2(sine, relative.w);
        let turn = core::f64::consts::TAU;
        angle - turn * libm::round(angle / turn)
    }

    /// Rate of the joint, rad/s.
    pub fn rate(&self, world: &PhysicsWorld) -> f64 {
        let [from, to] = self.bodies.map(|handle| &world.bodies[handle]);
        let axis = from.position().rotation * self.axis;
        (to.angvel() - from.angvel()).dot(axis)
    }
}

/// Handles to the robot's parts in the physics world.
pub struct Robot {
    /// All bodies in a fixed order: body, seat, front and rear yoke, front and rear arm, four
    /// wheels.
    pub bodies: [RigidBodyHandle; 10],
    /// Joints of the motors, in the motors' order.
    pub shafts: [Shafted; MOTORS],
    /// Colliders of the wheels.
    pub wheels: [ColliderHandle; 4],
}

/// Indices of the seat and of the first wheel in [`Robot::bodies`].
pub const SEAT: usize = 1;
const WHEELS: usize = 6;

fn box_inertia(mass: f64, x: f64, y: f64, z: f64) -> Vector {
    Vector::new(y * y + z * z, x * x + z * z, x * x + y * y) * (mass / 12.0)
}

/// Mass and inertia of the seat without load.
pub fn seat(p: &RtMoverParameters) -> Inertia {
    let m = &p.masses;
    Inertia {
        mass: m.seat,
        centre: Vector::new(m.seat_forward, 0.0, m.seat_height),
        about_centre: Matrix::from_diagonal(box_inertia(m.seat, 0.3, 0.3, 0.2)),
    }
}

/// Mass properties of [`Robot::bodies`].
pub fn mass_properties(p: &RtMoverParameters) -> [MassProperties; 10] {
    let (l, m) = (&p.lengths, &p.masses);
    let centred = |mass: f64, inertia: Vector| MassProperties::new(Vector::ZERO, mass, inertia);
    let struts = |mass: f64| {
        let [x, y, z] = box_inertia(mass, 0.05, 2.0 * l.half_arm, 0.05).to_array();
        centred(mass, Vector::new(x + STRUT, y + STRUT, z + STRUT))
    };
    let (yoke, arm) = (struts(YOKE * m.arm), struts((1.0 - YOKE) * m.arm));
    let disc = 0.5 * m.wheel * l.wheel_radius * l.wheel_radius;
    let wheel = centred(m.wheel, Vector::new(0.5 * disc, disc, 0.5 * disc));
    let body = centred(m.body, box_inertia(m.body, 0.5, 0.3, 0.1));
    let seat = seat(p).properties();
    [body, seat, yoke, yoke, arm, arm, wheel, wheel, wheel, wheel]
}

/// Names and shapes of [`Robot::bodies`].
pub fn shapes(p: &RtMoverParameters) -> Vec<BodyShape> {
    let (l, m) = (&p.lengths, &p.masses);
    let block = |centre, size| Part::Box { centre, size };
    let strut = block([0.0; 3], [0.05, 2.0 * l.half_arm, 0.05]);
    let yoke = block([0.0; 3], [0.08, 0.08, 0.08]);
    let wheel = Part::Wheel {
        centre: [0.0; 3],
        radius: l.wheel_radius,
        width: 2.0 * p.wheel_half_width,
    };
    let seat = block([m.seat_forward, 0.0, m.seat_height], [0.3, 0.3, 0.2]);
    [
        ("body", block([0.0; 3], [l.body, 0.1, 0.1])),
        ("seat", seat),
        ("front_yoke", yoke),
        ("rear_yoke", yoke),
        ("front_arm", strut),
        ("rear_arm", strut),
        ("front_left_wheel", wheel),
        ("front_right_wheel", wheel),
        ("rear_left_wheel", wheel),
        ("rear_right_wheel", wheel),
    ]
    .map(|(name, part)| BodyShape {
        name,
        parts: vec![part],
    })
    .to_vec()
}

impl Robot {
    /// Builds the robot with its middle above the origin, on ground through the origin with the
    /// orientation of `tilt`.
    pub fn build(world: &mut PhysicsWorld, p: &RtMoverParameters, tilt: Pose) -> Self {
        let l = &p.lengths;
        let start = tilt
            * Pose::from_parts(
                Vector::Z * (l.arm_drop + l.wheel_radius),
                turn(Vector::Z, p.initial_heading),
            );
        let mut body = |place: Vector, properties: MassProperties| {
            world.insert_body(
                RigidBodyBuilder::dynamic()
                    .pose(start * Pose::from_translation(place))
                    .additional_mass_properties(properties)
                    .can_sleep(false),
            )
        };
        let pivots = [0.5, -0.5].map(|side| Vector::X * (side * l.body));
        let hub = |wheel: usize| {
            let left = if wheel.is_multiple_of(2) { 1.0 } else { -1.0 };
            Vector::new(0.0, left * l.half_arm, -l.arm_drop)
        };
        let masses = mass_properties(p);
        let chassis = body(Vector::ZERO, masses[0]);
        let seat = body(Vector::ZERO, masses[1]);
        let yokes = [0, 1].map(|i| body(pivots[i], masses[2 + i]));
        let arms = [0, 1].map(|i| body(pivots[i], masses[4 + i]));
        let wheels = [0, 1, 2, 3]
            .map(|wheel: usize| body(pivots[wheel / 2] + hub(wheel), masses[WHEELS + wheel]));

        let mut join = |bodies: [RigidBodyHandle; 2], axis: Vector, anchor: Vector| Shafted {
            handle: world.insert_impulse_joint(
                bodies[0],
                bodies[1],
                RevoluteJointBuilder::new(axis)
                    .local_anchor1(anchor)
                    .local_anchor2(Vector::ZERO)
                    .motor_model(MotorModel::ForceBased),
            ),
            bodies,
            axis,
        };
        let steering = [0, 1].map(|i| join([chassis, yokes[i]], Vector::Z, pivots[i]));
        let roll = [0, 1].map(|i| join([yokes[i], arms[i]], Vector::X, Vector::ZERO));
        let pitch = join([chassis, seat], Vector::NEG_Y, Vector::ZERO);
        let rolling = [0, 1, 2, 3]
            .map(|wheel: usize| join([arms[wheel / 2], wheels[wheel]], Vector::Y, hub(wheel)));
        let [fl, fr, rl, rr] = rolling;
        let colliders = wheels.map(|wheel| {
            world.insert_collider(
                ColliderBuilder::cylinder(p.wheel_half_width, l.wheel_radius)
                    .density(0.0)
                    .friction(p.friction)
                    .friction_combine_rule(CoefficientCombineRule::Min)
                    // The robot touches the ground, but not itself.
                    .collision_groups(InteractionGroups::new(
                        Group::GROUP_2,
                        Group::GROUP_1,
                        InteractionTestMode::And,
                    )),
                Some(wheel),
            )
        });
        Self {
            bodies: [
                chassis, seat, yokes[0], yokes[1], arms[0], arms[1], wheels[0], wheels[1],
                wheels[2], wheels[3],
            ],
            shafts: [
                fl,
                fr,
                rl,
                rr,
                steering[0],
                steering[1],
                roll[0],
                roll[1],
                pitch,
            ],
            wheels: colliders,
        }
    }

    /// Points through which pictures draw the robot: the four hubs, both ends of the body, its
    /// middle, and the seat's centre of mass.
    pub fn points(&self, world: &PhysicsWorld, p: &RtMoverParameters) -> [Vector; 8] {
        let at = |body: usize, local: Vector| {
            world.bodies[self.bodies[body]]
                .position()
                .transform_point(local)
        };
        let seat = Vector::new(p.masses.seat_forward, 0.0, p.masses.seat_height);
        let hub = |wheel: usize| at(WHEELS + wheel, Vector::ZERO);
        let end = Vector::X * (0.5 * p.lengths.body);
        [
            hub(0),
            hub(1),
            hub(2),
            hub(3),
            at(0, end),
            at(0, -end),
            at(0, Vector::ZERO),
            at(SEAT, seat),
        ]
    }

    /// Lowest point of each wheel's middle plane, m.
    pub fn lowest_points(&self, world: &PhysicsWorld, p: &RtMoverParameters) -> [Vector; 4] {
        core::array::from_fn(|wheel| {
            let pose = world.bodies[self.bodies[WHEELS + wheel]].position();
            let axle = pose.rotation * Vector::Y;
            let down = Vector::NEG_Z - axle * Vector::NEG_Z.dot(axle);
            pose.translation + down.normalize_or_zero() * p.lengths.wheel_radius
        })
    }

    /// Upward forces of the ground on the wheels in the last step, N.
    pub fn loads(&self, world: &PhysicsWorld) -> [f64; 4] {
        let mut loads = [0.0; 4];
        for pair in world.contact_pairs() {
            let wheel = |handle| self.wheels.iter().position(|own| *own == handle);
            let (wheel, sign) = match (wheel(pair.collider1), wheel(pair.collider2)) {
                (Some(wheel), _) => (wheel, -1.0),
                (_, Some(wheel)) => (wheel, 1.0),
                _ => continue,
            };
            for manifold in pair.solver_manifolds() {
                let impulse: f64 = manifold.points.iter().map(|point| point.data.impulse).sum();
                loads[wheel] += manifold.data.normal.z * sign * impulse / DT;
            }
        }
        loads
    }
}
