//! Robots of the simulator: for each one, its nodes, their settings, and the plant that they move.
//!
//! One folder per robot: `section` is its section of a scenario file, `nodes` its nodes, `plant`
//! its simulated physics. `results` and `tools` have what the modules with these names ask of it;
//! they may use these modules. [`registry`] has the robots as values, [`section`] defines the
//! interface that each of them implements. [`node_name`], [`motors`] and [`payload`] are shared by
//! all.

pub mod b2p2;
pub mod crawler;
pub mod hylos;
pub mod motors;
pub mod node_name;
pub mod payload;
pub mod registry;
pub mod rt_mover;
pub mod section;

pub use node_name::NodeName;
pub use registry::{Kind, Robot};
pub use section::{Conditions, Facts, NodeSpec, Posture, Role, Section};
