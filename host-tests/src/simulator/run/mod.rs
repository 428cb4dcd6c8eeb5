//! Lockstep runner: runs node programs, a bus, a plant and an operator, one millisecond at a time.
//!
//! [`node`] communicates with one node over a `link`, `node_log` decodes its log, and `launch`
//! starts it. The link leads to a value in this process (`host`), to the `process` of an emulator,
//! or to a flash `image` on the model of its chip. [`operator`] plays the operator's script,
//! [`listener`] decodes the published frames, [`faults`] injects faults. `lockstep` runs one step,
//! [`pace`] follows the wall clock, and `recorder` runs all steps until one of the `conditions`
//! ends the run, and passes the record to a `sink`. `flash` holds the nodes'
//! flash. `options` are the inputs, `outcome` and `error`
//! the results.

mod conditions;
mod error;
pub mod faults;
mod flash;
mod host;
#[cfg(feature = "image")]
mod image;
mod launch;
mod link;
pub mod listener;
mod lockstep;
#[cfg(unix)]
mod log_texts;
pub mod node;
mod node_log;
pub mod operator;
mod options;
mod outcome;
pub mod pace;
#[cfg(unix)]
mod process;
mod recorder;
mod sink;

pub use error::RunError;
pub use link::WITHOUT_IMAGES;
pub use lockstep::Run;
pub use options::{Inject, Options};
pub use outcome::{Ending, Outcome};
pub use recorder::record;
pub use sink::{Sink, Unwritten};

use crate::programs::Programs;
use crate::scenario::Scenario;

/// Runs `scenario` with the nodes of `programs` and keeps all samples in memory.
///
/// # Errors
/// [`RunError`]. All node processes have ended when this returns.
pub fn run(
    scenario: &Scenario,
    programs: &Programs,
    options: Options,
) -> Result<Outcome, RunError> {
    let mut samples = Vec::new();
    let ending = record(scenario, programs, options, &mut samples)?;
    let outcome = Outcome {
        samples,
        facts: ending.facts,
        commands_s: ending.commands_s,
    };
    ending.error.map_or(Ok(outcome), Err)
}
