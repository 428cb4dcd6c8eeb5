//! Bodies, belts and joints of B2P2 in the physics engine.
//!
//! Body axes are x forward, y left, z up; the origins are axle 1, axle 2 and axle 3.

use super::parameters::{B2p2Parameters, SEGMENTS};
use crate::world::ground::Ground;
use crate::world::inertia::{Inertia, of_point};
use crate::world::load::Load;
use crate::world::physics::turn;
use rapier3d_f64::math::{Matrix, Pose, Vector};
use rapier3d_f64::prelude::*;

/// Marks of colliders: anything that is not a belt, the left belt, the right belt.
pub const MARKS: [u128; 3] = [0, 1, 2];
/// Handles to the robot's parts in the physics world.
pub struct Robot {
    /// Segments 1 to 3.
    pub bodies: [RigidBodyHandle; 3],
    /// Mass properties of the segments; those of segment 1 include the payload.
    pub masses: [MassProperties; 3],
    /// The chassis joint, turning about -y: front up is positive.
    pub joint: ImpulseJointHandle,
    /// The screw, sliding along x.
    pub screw: ImpulseJointHandle,
}

/// Adds the ground to the world and returns the pose in which the robot starts on it.
pub fn lay_ground(world: &mut PhysicsWorld, terrain: &Ground, parameters: &B2p2Parameters) -> Pose {
    let [pitch, roll] = terrain.inclination();
    let tilt = Pose::from_rotation(turn(Vector::X, roll) * turn(Vector::NEG_Y, pitch));
    for block in terrain.blocks() {
        let [x, y, z] = block.half;
        world.insert_collider(
            ColliderBuilder::cuboid(x, y, z)
                .position(
                    tilt * Pose::from_parts(
                        Vector::from_array(block.centre),
                        turn(Vector::NEG_Y, block.pitch),
                    ),
                )
                .friction(parameters.friction)
                .user_data(MARKS[0]),
            None,
        );
    }
    let [heading, y] = parameters.initial_heading_and_y;
    // Axle 3 may be lower than axle 1.
    let drop =
        -(parameters.l2 + parameters.initial_extension()) * libm::sin(parameters.initial_theta());
    let height = parameters.pulley_radius
        + parameters.initial_clearance
        + if drop > 0.0 { drop } else { 0.0 };
    tilt * Pose::from_parts(Vector::new(0.0, y, height), turn(Vector::Z, heading))
}

/// Mass properties of segment `index` (0 to 2) in body axes, with the payload if one is given.
pub fn mass_properties(
    parameters: &B2p2Parameters,
    index: usize,
    payload: Option<Load>,
) -> MassProperties {
    let segment = &SEGMENTS[index];
    // Columns: the D-H frame's axes in body axes (R6: forward, up, right; R7: up, backward, right;
    // R8: up, right, forward).
    let axes = match index {
        0 => Matrix::from_cols(Vector::X, Vector::Z, Vector::NEG_Y),
        1 => Matrix::from_cols(Vector::Z, Vector::NEG_X, Vector::NEG_Y),
        _ => Matrix::from_cols(Vector::Z, Vector::NEG_Y, Vector::X),
    };
    let com = Vector::from_array(segment.centre_of_mass);
    // Symmetric, so rows and columns are the same.
    let about_origin = Matrix::from_cols_array_2d(&segment.inertia_about_origin);
    let about_com = about_origin - of_point(segment.mass, com);
    let mut centre = axes * com;
    match index {
        0 => centre.z = parameters.body_1_com_height,
        2 => centre.x -= parameters.axle_3_from_r8,
        _ => {}
    }
    let bare = Inertia {
        mass: segment.mass,
        centre,
        about_centre: axes * about_com * axes.transpose(),
    };
    payload
        .map_or(bare, |payload| bare.with_load(&payload))
        .properties()
}

impl Robot {
    /// Builds the robot with axle 1 at `start`, and chassis angle and extension as at power-up.
    pub fn build(world: &mut PhysicsWorld, parameters: &B2p2Parameters, start: Pose) -> Self {
        let p = parameters;
        let theta = p.initial_theta();
        let extension = p.initial_extension();
        let front = start * Pose::from_parts(Vector::X * p.l1, turn(Vector::NEG_Y, theta));
        let poses = [
            start,
            front,
            front * Pose::from_translation(Vector::X * (p.l2 + extension)),
        ];
        let masses = [0, 1, 2].map(|index| mass_properties(p, index, None));
        let bodies = core::array::from_fn(|i| {
            world.insert_body(
                RigidBodyBuilder::dynamic()
                    .pose(poses[i])
                    .additional_mass_properties(masses[i])
                    .can_sleep(false),
            )
        });
        let joint = world.insert_impulse_joint(bodies[0], bodies[1], chassis_joint(p));
        let screw = world.insert_impulse_joint(
            bodies[1],
            bodies[2],
            PrismaticJointBuilder::new(Vector::X)
                .local_anchor1(Vector::X * p.l2)
                .local_anchor2(Vector::ZERO)
                .limits([p.screw_travel[0] - 0.005, p.screw_travel[1] + 0.005])
                .motor_model(MotorModel::ForceBased),
        );
        for side in 0..2 {
            belt(world, p, bodies, side);
        }
        Self {
            bodies,
            masses,
            joint,
            screw,
        }
    }

    /// Chassis angle, rad, and its rate, rad/s.
    pub fn chassis_joint(&self, world: &PhysicsWorld) -> [f64; 2] {
        let [rear, front, _] = self.bodies.map(|handle| &world.bodies[handle]);
        let relative = rear.position().rotation.inverse() * front.position().rotation;
        let axis = rear.position().rotation * Vector::NEG_Y;
        [
            -2.0 * libm::atan2(relative.y, relative.w),
            (front.angvel() - rear.angvel()).dot(axis),
        ]
    }

    /// Extension of the screw, m, and its rate, m/s.
    pub fn extension(&self, world: &PhysicsWorld, p: &B2p2Parameters) -> [f64; 2] {
        let [_, inner, outer] = self.bodies.map(|handle| &world.bodies[handle]);
        let axis = inner.position().rotation * Vector::X;
        let axle_3 = outer.position().translation;
        let apart = axle_3 - inner.position().translation;
        let speed = outer.velocity_at_point(axle_3) - inner.velocity_at_point(axle_3);
        [apart.dot(axis) - p.l2, speed.dot(axis)]
    }
}

/// Creates the chassis joint; its zero is the middle of the travel.
///
/// With stops that are symmetric about zero, the engine needs the sine and cosine of zero alone. It
/// takes them from the platform, which has these two exactly and others only nearly.
fn chassis_joint(p: &B2p2Parameters) -> GenericJoint {
    let middle = p.joint_middle();
    let stop = p.joint_travel[1] + 5.0_f64.to_radians() - middle;
    let mut joint: GenericJoint = RevoluteJointBuilder::new(Vector::NEG_Y)
        .local_anchor1(Vector::X * p.l1)
        .local_anchor2(Vector::ZERO)
        .limits([-stop, stop])
        .motor_model(MotorModel::ForceBased)
        .into();
    joint.local_frame1.rotation = turn(Vector::NEG_Y, middle) * joint.local_frame1.rotation;
    joint
}

/// Lateral position of a belt's middle, positive to the left, m.
pub fn lateral(p: &B2p2Parameters, side: usize) -> f64 {
    0.5 * (p.width - p.belt_width) * if side == 0 { 1.0 } else { -1.0 }
}

/// Creates the colliders of one belt where something presses it on the ground: a disc at each axle,
/// and the guide plates along the segments.
fn belt(world: &mut PhysicsWorld, p: &B2p2Parameters, bodies: [RigidBodyHandle; 3], side: usize) {
    let (radius, half_width) = (p.pulley_radius, 0.5 * p.belt_width);
    let mut add = |body: usize, x: f64, shape: ColliderBuilder| {
        let place = Vector::new(x, lateral(p, side), 0.0);
        world.insert_collider(
            shape
                .position(Pose::from_translation(place))
                // No mass, and the centre of it at the body's origin: then the engine's sum of
                // masses stays exactly that of the segment, and it does not look for the
                // principal axes of the sum, for which it would call the platform's functions.
                .mass_properties(MassProperties::new(-place, 0.0, Vector::ZERO))
                .friction(p.friction)
                .friction_combine_rule(CoefficientCombineRule::Min)
                // The robot touches the ground, but not itself.
                .collision_groups(InteractionGroups::new(
                    Group::GROUP_2,
                    Group::GROUP_1,
                    InteractionTestMode::And,
                ))
                .active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS)
                .user_data(MARKS[side + 1]),
            Some(bodies[body]),
        );
    };
    let disc = || ColliderBuilder::cylinder(half_width, radius);
    let plate = radius - p.guide_clearance;
    let bar = |length: f64| ColliderBuilder::cuboid(0.5 * length, half_width, plate);
    add(0, 0.0, disc());
    add(0, p.l1, disc());
    add(2, 0.0, disc());
    add(0, 0.5 * p.l1, bar(p.l1));
    // Each plate is as long as possible without protruding when the front part is shortest.
    let front = p.taut_length(0.0) - 0.02;
    add(1, 0.5 * front, bar(front));
    add(2, -0.5 * front, bar(front));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_weigh_and_turn_as_bodies_can() {
        let parameters = B2p2Parameters::nominal();
        let mut mass = 0.0;
        for index in 0..3 {
            let properties = mass_properties(&parameters, index, None);
            mass += properties.mass();
            let [x, y, z] = properties.principal_inertia().to_array();
            assert!(
                x > 0.0 && y > 0.0 && z > 0.0,
                "segment {index}: {x} {y} {z}"
            );
            assert!(
                x + y >= z && y + z >= x && z + x >= y,
                "segment {index}: {x} {y} {z}"
            );
            // No part of the robot is farther from its centre of mass than half its largest
            // dimension.
            assert!((x / properties.mass()).sqrt() < 0.3);
        }
        assert!((mass - 8.315_283).abs() < 1e-9);
        // The shift of body 3's inertia across its axis, calculated by hand: 0.02964 - 1.06215 *
        // 0.15268^2 = 0.00488.
        let front = mass_properties(&parameters, 2, None).reconstruct_inertia_matrix();
        assert!((front.y_axis.y - 0.00488).abs() < 1e-5, "{front}");
    }
}
