//! Plant of the crawler of Kurc and Szybicki: one rigid body on two tracks that shear the ground
//! under them.
//!
//! [`parameters`]: the constant model. [`ground`]: the ground's shape. `track`: belts, cells and
//! their contact with the ground. `body`: the rigid body. `start`: lets the robot settle. `step`:
//! the order of one step. `slip`: the slip of the tracks, which results from the forces and is not
//! prescribed. `truth`: the ground truth. `interface`: the implementation of
//! [`crate::world::Plant`].

mod body;
pub mod ground;
mod interface;
pub mod parameters;
mod slip;
mod start;
mod step;
mod track;
mod truth;

pub use body::MassProperties;
pub use ground::Profile;
pub use parameters::{CrawlerParameters, Soil};

use crate::world::gnss::Receiver;
use crate::world::load::Load;
use crate::world::sensing::BodySensing;
use crate::world::truth::Truth;
use body::Body;
use ground::Ground;
use track::Track;

/// Simulated crawler with its ground.
pub struct Crawler {
    parameters: CrawlerParameters,
    ground: Ground,
    body: Body,
    tracks: [Track; 2],
    sensing: BodySensing,
    receiver: Receiver,
    step: u64,
    payload: Option<Load>,
    truth: Truth,
}
