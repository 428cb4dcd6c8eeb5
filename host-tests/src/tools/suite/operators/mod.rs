//! `cargo demo --suite operators`: tests that an operator who commands at random cannot topple the
//! robot on fair ground.
//!
//! This module makes all runs on all cores. `plan` describes the runs, `operate` makes one of them,
//! `row` is its result, `known` finds results of earlier calls. [`edges`] decides what is fair
//! ground, [`journal`] writes each result as soon as it is known, [`table`] writes the table.
//! `suite::draw::operators` draws the runs.

pub mod edges;
pub mod journal;
mod known;
mod operate;
mod plan;
mod row;
pub mod table;

pub use known::text;
pub use operate::operate;
pub use plan::{Plan, drawn};
pub use row::{Commands, Row, Topple};

use super::SuiteError;
use super::cores::on_all_cores;
use crate::programs::Programs;
use crate::scenario::Scenario;
use known::reusable;

/// Maximum number of draws for one number. If all of them topple before the operator commands
/// anything, the last one is the result.
const MAXIMUM_DRAWS: u64 = 20;

/// Makes the runs of `plan` that are not among `known`, and calls `done` with each result and its
/// scenario. Returns all results by number.
///
/// # Errors
/// [`SuiteError`] of the first run that fails.
pub fn operators(
    plan: &Plan,
    programs: &Programs,
    known: &[Row],
    done: &(dyn Fn(&Row, &Scenario) + Sync),
) -> Result<Vec<Row>, SuiteError> {
    let numbers: Vec<u64> = (0..plan.runs).collect();
    on_all_cores(&numbers, |number| {
        if let Some(row) = reusable(plan, *number, programs, known)? {
            return Ok(row);
        }
        let (mut again, mut simulated_s) = (0, 0.0);
        loop {
            let scenario = drawn(plan, *number, again)?;
            let (mut row, commanded) = operate(&scenario, programs)?;
            simulated_s += row.simulated_s;
            let by_itself = row.topple.is_some() && !commanded;
            if !by_itself || again + 1 == MAXIMUM_DRAWS {
                row.seed = plan.seed;
                row.number = *number;
                row.drawn_again = again;
                row.simulated_s = simulated_s;
                done(&row, &scenario);
                return Ok(row);
            }
            again += 1;
        }
    })
}
