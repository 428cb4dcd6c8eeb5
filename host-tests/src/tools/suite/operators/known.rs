//! Finds results of earlier calls that can be used again, by the SHA-256 of scenario and programs.

use super::{Plan, Row, drawn};
use crate::programs::{Programs, hexadecimal};
use crate::scenario::Scenario;
use crate::tools::suite::SuiteError;
use sha2::{Digest, Sha256};

/// The known result of the run with this number, if it was made with the same scenario and
/// programs.
pub(super) fn reusable(
    plan: &Plan,
    number: u64,
    programs: &Programs,
    known: &[Row],
) -> Result<Option<Row>, SuiteError> {
    let of_this_run = |row: &&Row| row.seed == plan.seed && row.number == number;
    for row in known.iter().rev().filter(of_this_run) {
        let scenario = drawn(plan, number, row.drawn_again)?;
        if row.scenario == fingerprint(&text(&scenario)) && row.programs == of_programs(programs) {
            return Ok(Some(row.clone()));
        }
    }
    Ok(None)
}

/// The content of a scenario as the text of a file.
pub fn text(scenario: &Scenario) -> String {
    // A description consists of tables, numbers and texts, which can all be written.
    toml::to_string(scenario).unwrap_or_default()
}

pub(super) fn fingerprint(text: &str) -> String {
    hexadecimal(&Sha256::digest(text))
}

pub(super) fn of_programs(programs: &Programs) -> String {
    fingerprint(&programs.nodes.sha256)
}
