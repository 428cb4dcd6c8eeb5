//! The crawler of Kurc and Szybicki: one rigid body on two tracks that shear the ground under them.
//!
//! [`parameters`]: the constant model. [`ground`]: the ground's shape. `track`: belts, cells and
//! ground. `body`: the rigid body. `start`: how it comes to rest. `step`: the order of one step.
//! `slip`: the slip of the tracks, which is nowhere given: it comes out of the forces. `truth`:
//! what the physics knows. `interface`: the robot as a [`crate::world::Plant`].

mod body;
pub mod ground;
mod interface;
pub mod parameters;
mod slip;
mod start;
mod step;
mod track;
mod truth;

pub use ground::Profile;
pub use parameters::{CrawlerParameters, Soil};

use crate::world::gnss::Receiver;
use crate::world::load::Load;
use crate::world::sensing::BodySensing;
use crate::world::truth::Truth;
use body::Body;
use ground::Ground;
use track::Track;

/// The crawler on its ground.
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
