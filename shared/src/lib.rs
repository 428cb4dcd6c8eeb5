//! Control, kinematics and stability for robots that change their shape. This crate has all
//! decisions and computations of tautrack, but no hardware, clock, statics or allocation. So the
//! code that the tests run is the code that is flashed.
//!
//! Modules, lower layers first; no module uses a higher layer:
//!
//! 1. [`constants`], [`units`], [`sensors`], [`can`], [`settings`], [`faults`], [`math`]
//! 2. [`bus`], [`motor`], [`screw`], [`estimate`], [`sensing`], [`stability`]
//! 3. [`robots`]
//! 4. [`node`]
//! 5. [`link`] (feature `lockstep`), [`store`]
//! 6. [`roles`]
#![no_std]

extern crate self as tautrack;

pub mod bus;
pub mod can;
pub mod constants;
pub mod estimate;
pub mod fault_log;
pub mod faults;
#[cfg(feature = "lockstep")]
pub mod link;
pub mod math;
pub mod motor;
pub mod node;
pub mod robots;
pub mod roles;
pub mod screw;
pub mod sensing;
pub mod sensors;
pub mod settings;
pub mod stability;
pub mod store;
pub mod units;
