//! The tracked robot of Paillat et al.: three segments, a chassis joint, a driving screw and a pair of belts.
//!
//! [`parameters`]: the constant model. Construction: `B2p2::new(&B2p2Parameters, &Terrain, seed)`.

pub mod parameters;

pub use parameters::{B2p2Parameters, Payload};
