//! Simulator of tautrack: robots in their world, virtual bus, lockstep runner, scenarios, results
//! and tools. No part of it runs on a robot.
//!
//! A module uses only modules to its left: [`bounds`], [`programs`], [`world`], [`robots`],
//! [`scenario`], [`simulator`], [`results`], [`live`], [`tools`]. `tests/tools/layers.rs` reads the
//! `use` lines and checks this.

pub mod bounds;
pub mod live;
pub mod programs;
pub mod results;
pub mod robots;
pub mod scenario;
pub mod simulator;
#[cfg(unix)]
pub mod tools;
pub mod world;
