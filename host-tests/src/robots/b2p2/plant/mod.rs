//! Plant of B2P2, the tracked robot of Paillat et al.: three segments, a chassis joint, a driving
//! screw and a pair of belts.
//!
//! [`parameters`]: the constant model. `robot`: bodies and joints in the physics engine. `contact`:
//! contact of belts and ground. [`belt`]: the belts between the pulleys. `start`: puts all of them
//! into the engine. `step`: the order of one step. `sensing`: the readings of the motors' sensors.
//! `truth`: the ground truth. `interface`: the implementation of [`crate::world::Plant`].

pub mod belt;
mod contact;
mod interface;
pub mod parameters;
mod robot;
mod sensing;
mod start;
mod step;
mod truth;

pub use parameters::B2p2Parameters;
pub use robot::mass_properties;

use crate::world::TrackFault;
use crate::world::gear::{Gear, Sprocket};
use crate::world::gnss::Receiver;
use crate::world::ground::Ground;
use crate::world::hand::Grip;
use crate::world::load::Load;
use crate::world::sensing::BodySensing;
use crate::world::truth::Truth;
use belt::Belts;
use contact::{GroundForces, Support};
use rapier3d_f64::prelude::PhysicsWorld;
use robot::Robot;

/// Simulated B2P2 with its ground.
pub struct B2p2 {
    parameters: B2p2Parameters,
    world: PhysicsWorld,
    robot: Robot,
    sprockets: [Sprocket; 2],
    track_faults: [TrackFault; 2],
    belts: Belts,
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
    grip: Grip,
    terrain: Ground,
    /// Normal of the whole terrain, which may be inclined.
    up: [f64; 3],
    truth: Truth,
}
