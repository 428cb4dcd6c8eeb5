//! `cargo demo --suite hazards`: tests that the guard saves the robot from hazards and does not
//! hinder legitimate runs.
//!
//! A hazard topples the robot without the guard and must not topple it with the guard. The guard
//! must also leave the operator alone for as long as possible. Trial runs, in which the operator
//! lets go, find the last moment at which letting go still saves the robot. The suite reports how
//! long before it the guard first acted. In a legitimate run the guard must not hinder the
//! operator.
//!
//! `hazards` runs this suite: [`evaluation`] evaluates one scenario, `lead` how early the guard
//! acts, [`interruption`] a restart or a reset, [`draw`] draws scenarios, `findings` holds the
//! results, [`table`] writes them. [`operators`] is the suite of operators who command at random.
//! [`clearance`] is the suite of obstacles that B2P2 clears by itself.
//! [`command`] runs the suites for the command line, `cores` runs jobs on all cores.

pub mod clearance;
pub mod command;
mod cores;
pub mod draw;
mod error;
pub mod evaluation;
mod findings;
mod hazards;
pub mod interruption;
mod lead;
pub mod operators;
pub mod table;

pub use error::SuiteError;
pub use findings::{Drawn, Findings};
pub use hazards::{drawn_runs, suite};
