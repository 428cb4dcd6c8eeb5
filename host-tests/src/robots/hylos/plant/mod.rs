//! Plant of Hylos, the wheel-legged robot of Besseron et al.: a platform on four legs, each with a
//! steered and driven wheel, and sixteen motors.
//!
//! [`parameters`]: the constant model. [`hillside`]: the ground. `robot`: bodies and joints in the
//! physics engine. `start`: puts both into the engine. `legs`: gears and joints of a leg.
//! `sensing`: the readings of the motors' sensors. `truth`: the ground truth. `interface`: the
//! implementation of [`crate::world::Plant`], with the order of one step.

pub mod hillside;
mod interface;
mod legs;
pub mod parameters;
mod robot;
mod sensing;
mod start;
mod truth;

pub use hillside::Hillside;
pub use parameters::HylosParameters;
pub use robot::mass_properties;
pub use truth::Detail;

use crate::world::gear::Gear;
use crate::world::sensing::BodySensing;
use crate::world::truth::Truth;
use rapier3d_f64::prelude::PhysicsWorld;
use robot::Robot;
use tautrack::robots::hylos::LEGS;

/// Number of motors. Their order is that of their nodes: hip, knee, steering and wheel of the front
/// left leg, then front right, rear left, rear right.
pub const MOTORS: usize = 4 * LEGS;
/// Indices of hip, knee, steering and wheel within a leg.
const HIP: usize = 0;
const KNEE: usize = 1;
const STEERING: usize = 2;
const WHEEL: usize = 3;

/// Simulated Hylos with its ground.
pub struct Hylos {
    parameters: HylosParameters,
    hillside: Hillside,
    world: PhysicsWorld,
    robot: Robot,
    /// Gears of hip, knee and steering of each leg.
    gears: [[Gear; 3]; LEGS],
    /// Whether the node of each wheel is alive.
    driven: [bool; LEGS],
    /// Torques that the gears of hips and knees transmitted in the last step, N m.
    leg_torques: [[f64; 2]; LEGS],
    standing_until: [u64; LEGS],
    body_sensing: BodySensing,
    step: u64,
    truth: Truth,
    detail: Detail,
}
