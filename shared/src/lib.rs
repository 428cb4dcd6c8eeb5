//! Control, kinematics and stability for robots that change their own shape: everything of tautrack that can be right
//! or wrong, without hardware, clock, statics or allocation, so that the code that is flashed is the code that is tested.
//!
//! Rooms, lower ones first; none uses a higher one: [`constants`], [`units`], [`sensors`], [`can`],
//! [`settings`], [`faults`], [`math`] · [`bus`], [`motor`], [`screw`], [`stability`], [`estimate`] ·
//! [`robots`] · [`node`] · [`link`] (feature `lockstep`).
#![no_std]

pub mod bus;
pub mod can;
pub mod constants;
pub mod estimate;
pub mod faults;
#[cfg(feature = "lockstep")]
pub mod link;
pub mod math;
pub mod motor;
pub mod node;
pub mod robots;
pub mod screw;
pub mod sensors;
pub mod settings;
pub mod stability;
pub mod units;
