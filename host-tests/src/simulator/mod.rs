//! A run: firmware nodes on a virtual bus, in lockstep with a robot's plant.
//!
//! [`run`] holds them together, [`bus`] is the CAN bus between them, [`slcan`] lets programs on the host join that bus, [`record`]
//! and [`facts`] are what a run leaves behind.

pub mod bus;
pub mod facts;
pub mod record;
pub mod run;
pub mod slcan;
