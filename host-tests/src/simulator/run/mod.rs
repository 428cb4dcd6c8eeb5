//! The lockstep runner: node programs, one bus, one plant, one operator, a millisecond at a time.
//!
//! [`process`] talks to one node program, `node_log` reads what it logs, `launch` starts it,
//! [`operator`] drives, [`listener`] decodes what the bus makes public, [`faults`] makes things go
//! wrong, `lockstep` is the order of one step, [`pace`] keeps to the wall clock, `recorder` goes
//! from the first step to the last one, which `conditions` decides. `options`, `outcome` and
//! `error` are what goes in and what comes out.

mod conditions;
mod error;
pub mod faults;
mod launch;
pub mod listener;
mod lockstep;
mod node_log;
pub mod operator;
mod options;
mod outcome;
pub mod pace;
pub mod process;
mod recorder;

pub use error::RunError;
pub use options::Options;
pub use outcome::{Outcome, Progress};
pub use recorder::record;

use crate::programs::Programs;
use crate::scenario::Scenario;

/// Runs `scenario` with the nodes of `programs` and calls `progress` at every sample.
///
/// # Errors
/// [`RunError`]; no node outlives the call.
pub fn run(
    scenario: &Scenario,
    programs: &Programs,
    options: Options,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Outcome, RunError> {
    let (outcome, broken) = record(scenario, programs, options, progress)?;
    broken.map_or(Ok(outcome), Err)
}
