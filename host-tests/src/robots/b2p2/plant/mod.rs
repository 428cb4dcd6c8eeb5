//! The tracked robot of Paillat et al.: three segments, a chassis joint, a driving screw and a pair
//! of belts.
//!
//! [`parameters`]: the constant model. `robot`: bodies and joints in the physics engine. `contact`:
//! belts and ground. `start`: how both get into the engine. `step`: the order of one step.
//! `sensing`: what the motors' sensors read. `truth`: what the physics knows. `interface`: the
//! robot as a [`crate::world::Plant`].

mod contact;
mod interface;
pub mod parameters;
mod robot;
mod sensing;
mod start;
mod step;
mod truth;

pub use parameters::B2p2Parameters;

use crate::world::gear::{Belt, Gear};
use crate::world::gnss::Receiver;
use crate::world::ground::Ground;
use crate::world::load::Load;
use crate::world::sensing::BodySensing;
use crate::world::truth::Truth;
use contact::{GroundForces, Support};
use rapier3d_f64::prelude::PhysicsWorld;
use robot::Robot;

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
    payload: Option<Load>,
    terrain: Ground,
    /// Normal of the whole ground.
    up: [f64; 3],
    truth: Truth,
}
