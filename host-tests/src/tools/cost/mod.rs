//! `cargo cost`: measures the cost of the control code on a Cortex-M4F. It counts instructions in
//! the emulator and never measures time.
//!
//! [`emulator`] runs the firmware's `cost` program and reads its counts. [`trace`] runs it again
//! and records every instruction, for which [`cycles`] models the time. [`image`] reads the sizes
//! of programs, [`stack`] measures their stacks, and `measurement` combines all of these.
//! [`ledger`] reads and writes ceilings and pinned counts in `cost.toml`, [`page`] writes
//! docs/cost.md, and `command` is the command line.

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
