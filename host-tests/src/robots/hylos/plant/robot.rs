//! Bodies and joints of Hylos in the physics engine: a platform, and four carriers with one wheel
//! each.
//!
//! The legs have no mass of their own, and their parallelograms keep the carriers parallel to the
//! platform. A leg is therefore one joint, in which the carrier slides forward and up and turns
//! about the steering axis. The leg's kinematics convert the angles of hip and knee to the
//! carrier's place, and the force there to torques on their shafts. The axes of this joint are x
//! up, y forward, z to the left.

use super::parameters::HylosParameters;
use crate::world::physics::{DT, SUBSTEPS, turn};
use rapier3d_f64::math::{Matrix, Pose, Rotation, Vector};
use rapier3d_f64::prelude::*;
use tautrack::robots::hylos::LEGS;

/// Height of the wheels above the ground at power-up, m.
const CLEARANCE: f64 = 0.002;
/// Moment of inertia of a carrier about any axis, kg m^2: that of a compact mass of 5 cm.
const CARRIER_INERTIA: f64 = 0.004;

/// Handles to the robot's parts in the physics world.
pub struct Robot {
    pub platform: RigidBodyHandle,
    pub carriers: [RigidBodyHandle; LEGS],
    pub wheels: [RigidBodyHandle; LEGS],
    pub tyres: [ColliderHandle; LEGS],
    /// Joints between platform and carriers.
    pub legs: [ImpulseJointHandle; LEGS],
    /// Joints between carriers and wheels; they turn about the axle, which points to the left.
    pub axles: [ImpulseJointHandle; LEGS],
}

/// Orientation of the frame of a leg's joint in the platform's axes.
fn leg_frame() -> Rotation {
    Rotation::from_mat3(&Matrix::from_cols(Vector::Z, Vector::X, Vector::Y))
}

/// Returns 1 for the front legs, -1 for the rear ones.
pub fn forward(leg: usize) -> f64 {
    if leg < 2 { 1.0 } else { -1.0 }
}

/// Hip of a leg, moved outward to the plane of its wheel, in the platform's axes, m.
fn hip(p: &HylosParameters, leg: usize) -> Vector {
    let m = &p.measures;
    let left = if leg.is_multiple_of(2) { 1.0 } else { -1.0 };
    Vector::new(
        forward(leg) * m.hip[0],
        left * (m.hip[1] + m.wheel_offset),
        0.0,
    )
}

/// Hip, knee and wheel centre of a leg in the platform's axes, m. Pictures draw the leg through
/// these points.
pub fn leg_places(p: &HylosParameters, leg: usize, [angle, bend]: [f64; 2]) -> [Vector; 3] {
    let from_hip =
        |[forth, down]: [f64; 2]| hip(p, leg) + Vector::new(forward(leg) * forth, 0.0, -down);
    let thigh = p.measures.leg[0];
    [
        hip(p, leg),
        from_hip([thigh * libm::cos(angle), thigh * libm::sin(angle)]),
        from_hip(p.reach([angle, bend])),
    ]
}

/// Mass properties of the platform, of a carrier and of a wheel.
pub fn mass_properties(p: &HylosParameters) -> [MassProperties; 3] {
    let m = &p.measures;
    let platform = p
        .platform_gyration
        .map(|radius| m.platform_mass * radius * radius);
    let carrier = Vector::splat(CARRIER_INERTIA);
    let spin = p.tyre_mass * m.wheel_radius * m.wheel_radius;
    let wheel = Vector::new(0.6 * spin, spin, 0.6 * spin);
    [
        MassProperties::new(
            Vector::from_array(m.platform_com),
            m.platform_mass,
            Vector::from_array(platform),
        ),
        MassProperties::new(Vector::ZERO, m.wheel_mass - p.tyre_mass, carrier),
        MassProperties::new(Vector::ZERO, p.tyre_mass, wheel),
    ]
}

impl Robot {
    /// Builds the robot on ground with this height and normal below its middle.
    pub fn build(world: &mut PhysicsWorld, p: &HylosParameters, height: f64, up: Vector) -> Self {
        let m = &p.measures;
        let [reach, below] = p.reach(p.initial_leg);
        let level = turn(Vector::Z, p.start[2]);
        let tilted = Rotation::from_rotation_arc(Vector::Z, up) * level;
        let ground = Vector::new(p.start[0], p.start[1], height);
        let start = Pose::from_parts(ground + up * (below + m.wheel_radius + CLEARANCE), tilted);

        let masses = mass_properties(p);
        let mut body = |place: Vector, properties: MassProperties| {
            world.insert_body(
                RigidBodyBuilder::dynamic()
                    .pose(start * Pose::from_translation(place))
                    .additional_mass_properties(properties)
                    .can_sleep(false),
            )
        };
        let platform = body(Vector::ZERO, masses[0]);
        let hub = |leg| hip(p, leg) + Vector::new(forward(leg) * reach, 0.0, -below);
        let carriers = core::array::from_fn(|leg| body(hub(leg), masses[1]));
        let wheels = core::array::from_fn(|leg| body(hub(leg), masses[2]));
        let shoulder = p.tyre_shoulder;
        let tyres = core::array::from_fn(|leg| {
            world.insert_collider(
                ColliderBuilder::round_cylinder(0.005, m.wheel_radius - shoulder, shoulder)
                    .density(0.0)
                    .friction(p.friction)
                    .friction_combine_rule(CoefficientCombineRule::Min),
                Some(wheels[leg]),
            )
        });
        let legs = core::array::from_fn(|leg| {
            let joint = GenericJointBuilder::new(
                JointAxesMask::LIN_Z | JointAxesMask::ANG_Y | JointAxesMask::ANG_Z,
            )
            .local_frame1(Pose::from_parts(hip(p, leg), leg_frame()))
            .local_frame2(Pose::from_parts(Vector::ZERO, leg_frame()))
            .motor_model(JointAxis::LinX, MotorModel::ForceBased)
            .motor_model(JointAxis::LinY, MotorModel::ForceBased)
            .motor_model(JointAxis::AngX, MotorModel::ForceBased)
            .contacts_enabled(false);
            world.insert_impulse_joint(platform, carriers[leg], joint)
        });
        let axles = core::array::from_fn(|leg| {
            let joint = RevoluteJointBuilder::new(Vector::Y)
                .motor_model(MotorModel::ForceBased)
                .contacts_enabled(false);
            world.insert_impulse_joint(carriers[leg], wheels[leg], joint)
        });
        Self {
            platform,
            carriers,
            wheels,
            tyres,
            legs,
            axles,
        }
    }

    /// Position of a wheel's centre relative to its hip, m: forward (backward at the rear) and
    /// down.
    pub fn reach(&self, world: &PhysicsWorld, p: &HylosParameters, leg: usize) -> [f64; 2] {
        let platform = world.bodies[self.platform].position();
        let hub = world.bodies[self.carriers[leg]].position().translation;
        let from_hip = platform.inverse_transform_point(hub) - hip(p, leg);
        [forward(leg) * from_hip.x, -from_hip.z]
    }

    /// Steering angle, rad, counter-clockwise seen from above.
    pub fn steering(&self, world: &PhysicsWorld, leg: usize) -> f64 {
        let [platform, carrier] = [self.platform, self.carriers[leg]]
            .map(|handle| world.bodies[handle].position().rotation);
        let relative = platform.inverse() * carrier;
        2.0 * libm::atan2(relative.z, relative.w)
    }

    /// Force or torque that a motor transmitted to its joint in the last substep, N or N m,
    /// positive along the joint.
    pub fn passed_on(world: &PhysicsWorld, joint: ImpulseJointHandle, axis: JointAxis) -> f64 {
        let motor = world
            .impulse_joints
            .get(joint)
            .and_then(|joint| joint.data.motor(axis));
        motor.map_or(0.0, |motor| -motor.impulse * SUBSTEPS as f64 / DT)
    }

    /// Sums of the ground's normal forces on the wheels in the last step, N.
    pub fn wheel_forces(&self, world: &PhysicsWorld) -> [f64; LEGS] {
        let mut forces = [0.0; LEGS];
        for pair in world.contact_pairs() {
            let tyre = self
                .tyres
                .iter()
                .position(|tyre| *tyre == pair.collider1 || *tyre == pair.collider2);
            let Some(leg) = tyre else { continue };
            for manifold in pair.manifolds() {
                for point in &manifold.points {
                    forces[leg] += point.data.impulse / DT;
                }
            }
        }
        forces
    }
}
