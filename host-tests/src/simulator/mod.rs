//! Runs firmware nodes on a virtual bus, in lockstep with a robot's plant.
//!
//! [`run`] executes the run, [`bus`] is the CAN bus between the nodes, [`slcan`] lets programs on
//! the host join that bus. [`record`] and [`facts`] hold the results. With the feature `image`,
//! `chip` executes the flash images of the motor board.

pub mod bus;
#[cfg(feature = "image")]
pub mod chip;
pub mod facts;
pub mod record;
pub mod run;
pub mod slcan;
