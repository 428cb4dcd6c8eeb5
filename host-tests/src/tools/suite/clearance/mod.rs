//! `cargo demo --suite clearance`: B2P2 clears drawn obstacles by itself.
//!
//! `draw` draws obstacles, `failure` what fails in the middle of a phase. `model` says by statics
//! which obstacles the robot can clear, `row` runs one, `table` writes the tables, [`grid`]
//! compares statics and simulation over riser and run, `shards` splits a suite into parts and
//! merges their results.

pub mod draw;
pub mod failure;
pub mod grid;
pub mod model;
pub mod row;
pub mod shards;
pub mod table;

pub use row::{Ending, Row};
pub use shards::Shard;

use super::SuiteError;
use super::cores::on_all_cores;
use crate::programs::Programs;
use crate::scenario::Scenario;

/// Makes the runs of one shard, and calls `done` with each result.
///
/// # Errors
/// [`SuiteError`] of the first run that fails.
pub fn clearance(
    (runs, seed, faulty): (u64, u64, bool),
    shard: Shard,
    programs: &Programs,
    done: &(dyn Fn(&Row, &Scenario) + Sync),
) -> Result<Vec<Row>, SuiteError> {
    let numbers: Vec<u64> = (0..runs).filter(|number| shard.has(*number)).collect();
    on_all_cores(&numbers, |number| {
        let (scenario, obstacle, failure) =
            draw::draw(seed, *number, faulty).map_err(SuiteError::Scenario)?;
        let mut row = row::clear(&scenario, &obstacle, failure, programs)?;
        (row.seed, row.number) = (seed, *number);
        let mut scenario = scenario.description();
        let fault = row.failed.as_ref().and_then(|failed| failed.fault.clone());
        scenario.faults.extend(fault);
        let scenario = Scenario::checked(scenario).map_err(SuiteError::Scenario)?;
        done(&row, &scenario);
        Ok(row)
    })
}
