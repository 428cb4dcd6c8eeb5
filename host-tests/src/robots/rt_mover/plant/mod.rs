//! Plant of Nakajima's RT-Mover: body, seat on its pitch shaft, two arms that steer and roll, four
//! wheels, nine motors.
//!
//! [`parameters`]: the constant model. `robot`: bodies and joints in the physics engine. `start`:
//! puts them and the ground into the engine. `step`: the order of one step. `sensing`: the readings
//! of the motors' sensors. `margin`: the support by the wheels. `truth`: the ground truth.
//! `interface`: the implementation of [`crate::world::Plant`].

mod interface;
mod margin;
pub mod parameters;
mod robot;
mod sensing;
mod start;
mod step;
mod truth;

pub use parameters::RtMoverParameters;
pub use robot::{MOTORS, mass_properties};
pub use sensing::SWITCH;

use crate::world::gear::Gear;
use crate::world::ground::Ground;
use crate::world::load::Load;
use crate::world::sensing::BodySensing;
use crate::world::truth::Truth;
use rapier3d_f64::math::Vector;
use rapier3d_f64::prelude::PhysicsWorld;
use robot::Robot;

/// Simulated RT-Mover with its ground.
pub struct RtMover {
    parameters: RtMoverParameters,
    world: PhysicsWorld,
    robot: Robot,
    gears: [Gear; MOTORS],
    rates: [f64; MOTORS],
    sensing: BodySensing,
    step: u64,
    terrain: Ground,
    /// Normal of the whole terrain, which may be inclined.
    up: [f64; 3],
    lowest: [Vector; 4],
    loads: [f64; 4],
    standing_until: [u64; 4],
    payload: Option<Load>,
    truth: Truth,
}
