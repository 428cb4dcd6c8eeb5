//! `cargo demo --suite hazards`: what the guard saves, and what it must not hinder.
//!
//! A hazard topples without the guard and must not with it, and the guard must leave the operator
//! alone for as long as it can: by trial runs in which the operator lets go, the suite finds the
//! last moment at which that still saves the robot, and says how far before it the guard first
//! acted. A legitimate run must pass unhindered.
//!
//! `hazards` is this suite: [`evaluation`] evaluates one scenario, [`interruption`] one with a restart
//! or a reset, [`draw`] draws scenarios, `findings` holds the results, [`table`] writes them.
//! [`operators`] is the suite of operators who command at random. [`command`] runs both as the user
//! commands, `cores` on all cores.

pub mod command;
mod cores;
pub mod draw;
mod error;
pub mod evaluation;
mod findings;
mod hazards;
pub mod interruption;
pub mod operators;
pub mod table;

pub use error::SuiteError;
pub use findings::{Drawn, Findings};
pub use hazards::{drawn_runs, suite};
