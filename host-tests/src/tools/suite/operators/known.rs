//! Recognises a result of an earlier call by the fingerprints of scenario and programs.

use super::{Plan, Row, drawn};
use crate::programs::{Programs, hexadecimal};
use crate::scenario::Scenario;
use crate::tools::suite::SuiteError;
use sha2::{Digest, Sha256};

/// A known result of this very run with these very programs.
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

/// A scenario as a file.
pub fn text(scenario: &Scenario) -> String {
    // A description consists of tables, numbers and texts: all of it can be written.
    toml::to_string(scenario).unwrap_or_default()
}

pub(super) fn fingerprint(text: &str) -> String {
    hexadecimal(&Sha256::digest(text))
}

pub(super) fn of_programs(programs: &Programs) -> String {
    let all = [&programs.axle, &programs.screw, &programs.guard];
    fingerprint(&all.map(|program| program.sha256.as_str()).concat())
}
