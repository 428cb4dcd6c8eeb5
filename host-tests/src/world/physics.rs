//! Settings of the physics engine that all plants share.

use crate::world::truth::BodyPose;
use rapier3d_f64::dynamics::SpringCoefficients;
use rapier3d_f64::math::{Rotation, Vector};
use rapier3d_f64::prelude::*;
use tautrack::constants::GRAVITY_F64;

/// Length of a step, s.
pub const DT: f64 = 1.0e-3;
/// Number of the solver's substeps in one step.
pub const SUBSTEPS: usize = 4;

/// Creates an empty world. Its settings prevent belts from sinking into the noses of steps and from
/// slipping on them.
pub fn world() -> PhysicsWorld {
    let mut world = PhysicsWorld::new();
    // A few colliders need no optimised tree, and the optimiser calls the platform's logarithm.
    world.broad_phase = BroadPhaseBvh::with_optimization_strategy(BvhOptimizationStrategy::None);
    world.gravity = Vector::new(0.0, 0.0, -GRAVITY_F64);
    let settings = &mut world.integration_parameters;
    settings.dt = DT;
    settings.num_solver_iterations = SUBSTEPS;
    settings.static_contact_softness = SpringCoefficients::new(200.0, 1.0);
    settings.friction_model = FrictionModel::Coulomb;
    // With one iteration each, a gear has only half its stiffness; with these numbers it lacks 8 %.
    settings.num_internal_pgs_iterations = 4;
    settings.num_internal_stabilization_iterations = 2;
    settings.warmstart_joints = true;
    // Belt forces are read from the contacts, so contacts must not be merged or skipped.
    settings.contact_clustering = false;
    settings.contact_recycling = false;
    settings.max_ccd_substeps = 0;
    settings.normalized_prediction_distance = 0.005;
    world
}

/// Rotation by `angle` (rad) about the unit vector `axis`, bit-identical on every machine.
pub fn turn(axis: Vector, angle: f64) -> Rotation {
    let imaginary = axis * libm::sin(0.5 * angle);
    Rotation::from_xyzw(
        imaginary.x,
        imaginary.y,
        imaginary.z,
        libm::cos(0.5 * angle),
    )
}

/// Pose of a body, as recorded.
pub fn pose(body: &RigidBody) -> BodyPose {
    let pose = body.position();
    BodyPose {
        place: pose.translation.to_array(),
        rotation: pose.rotation.to_array(),
    }
}
