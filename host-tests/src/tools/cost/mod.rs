//! `cargo cost`: what the control code costs on a Cortex-M4F, counted in the emulator, never timed.
//!
//! [`emulator`] runs the firmware's `cost` program and reads its counts; [`trace`] runs it once
//! more and sees every instruction, of which [`cycles`] makes a model of the time; [`image`] reads
//! the sizes of programs, [`stack`] the depth of their stacks; `measurement` calls them all.
//! [`ledger`] holds the ceilings and the pinned counts of `cost.toml`, and [`page`] writes
//! docs/cost.md. `command` is the command line.

mod command;
pub mod cycles;
pub mod emulator;
mod error;
pub mod image;
pub mod ledger;
mod measurement;
pub mod page;
pub mod stack;
pub mod trace;

pub use command::main;
pub use error::CostError;
pub use measurement::{CALLS, Entry, Measurement, measure};

/// Core clock of the motor board, Hz.
pub const CORE_HZ: f64 = 170e6;
