//! The robots as a run sees them: which nodes there are, what each is told about itself, and which plant they move.
//!
//! One folder per robot: `section` is what a scenario says of it, `nodes` its nodes, `plant` its physics. [`registry`] has a line for
//! each, [`section`] is what each has to say. [`node_name`] and [`payload`] are what all have.

pub mod b2p2;
pub mod crawler;
pub mod hylos;
pub mod node_name;
pub mod payload;
pub mod registry;
pub mod rt_mover;
pub mod section;

pub use node_name::NodeName;
pub use registry::{Kind, Robot};
pub use section::{Conditions, Facts, NodeSpec, Posture, Role, Section};
