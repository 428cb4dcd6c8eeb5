//! The nodes of tautrack: what is left to do around the control core before it is a program on a board.
//!
//! [`boards`] the contract with the hardware, and the hardware · [`current_loop`] the PWM interrupt · [`bus`] CANopen ·
//! [`serial`] the serial line · [`watchdog`] whether all parts still run · [`roles`] the tasks of
//! each kind of node · `cost` what the code costs on the core. A binary picks one role and runs it
//! on the selected board.
#![no_std]
// The logging macros of the target know no inline arguments.
#![allow(clippy::uninlined_format_args)]

#[cfg(not(target_os = "none"))]
extern crate std;

pub mod boards;
pub mod bus;
#[cfg(all(target_os = "none", feature = "mps2"))]
pub mod cost;
pub mod current_loop;
pub mod roles;
pub mod serial;
pub mod watchdog;

// The same macros on both sides: records of a few bytes where the output is an ELF file for a target, else text.
#[cfg(target_os = "none")]
pub(crate) use defmt as logger;
#[cfg(not(target_os = "none"))]
pub(crate) use log as logger;
