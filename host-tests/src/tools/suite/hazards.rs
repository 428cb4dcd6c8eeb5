//! Runs the hazard suite on all cores.

use super::cores::on_all_cores;
use super::draw::{Kind, draw};
use super::evaluation::{Row, Thoroughness, hazard, legitimate};
use super::{Drawn, Findings, SuiteError};
use crate::programs::Programs;
use crate::scenario::{Scenario, Sensors};
use std::path::Path;

/// Maximum number of draws for one number. If none of them is of the kind, the last one is the
/// result.
const MOST_DRAWS: u64 = 20;

/// Runs all scenarios of `folder`/hazards and `folder`/legitimate, then `random` drawn ones of each
/// kind, with `sensors` at these rates. Calls `done` with each row as soon as it is known.
///
/// # Errors
/// [`SuiteError`] of the first scenario that cannot be run.
pub fn suite(
    folder: &Path,
    random: u64,
    seed: u64,
    sensors: Sensors,
    programs: &Programs,
    done: &(dyn Fn(&Row) + Sync),
) -> Result<Findings, SuiteError> {
    let mut work = Vec::new();
    for kind in Kind::ALL {
        let scenarios = scenarios(&folder.join(kind.folder()))?;
        work.extend(scenarios.into_iter().map(|scenario| (kind, scenario)));
    }
    let with = |scenario: &Scenario| scenario.with_sensors(sensors).map_err(SuiteError::Scenario);
    let named = on_all_cores(&work, |(kind, scenario)| {
        let row = judged(*kind, &with(scenario)?, Thoroughness::Full, programs)?;
        done(&row);
        Ok(row)
    })?;
    let mut drawn = [const { None }; 2];
    for (place, kind) in drawn.iter_mut().zip(Kind::ALL) {
        *place = Some(drawn_runs(kind, random, seed, sensors, programs, done)?);
    }
    Ok(Findings {
        named,
        seed,
        drawn: drawn.map(Option::unwrap_or_default),
    })
}

/// Runs the drawn scenarios of `kind` with the numbers below `count`.
///
/// # Errors
/// As [`suite`].
pub fn drawn_runs(
    kind: Kind,
    count: u64,
    seed: u64,
    sensors: Sensors,
    programs: &Programs,
    done: &(dyn Fn(&Row) + Sync),
) -> Result<Drawn, SuiteError> {
    let numbers: Vec<u64> = (0..count).collect();
    let rows = on_all_cores(&numbers, |number| {
        let (mut again, mut simulated_s) = (0, 0.0);
        loop {
            let scenario = draw(kind, seed, *number, again)
                .and_then(|scenario| scenario.with_sensors(sensors))
                .map_err(SuiteError::Scenario)?;
            let mut row = judged(kind, &scenario, Thoroughness::Quick, programs)?;
            simulated_s += row.simulated_s;
            row.simulated_s = simulated_s;
            if row.is_of_its_kind() || again + 1 == MOST_DRAWS {
                done(&row);
                return Ok((row, again));
            }
            again += 1;
        }
    })?;
    Ok(Drawn {
        redrawn: rows.iter().map(|(_, again)| again).sum(),
        rows: rows.into_iter().map(|(row, _)| row).collect(),
    })
}

fn judged(
    kind: Kind,
    scenario: &Scenario,
    thoroughness: Thoroughness,
    programs: &Programs,
) -> Result<Row, SuiteError> {
    match kind {
        Kind::Hazard => hazard(scenario, thoroughness, programs),
        Kind::Legitimate => legitimate(scenario, thoroughness, programs),
    }
}

fn scenarios(folder: &Path) -> Result<Vec<Scenario>, SuiteError> {
    let unreadable = |error| SuiteError::Folder(folder.to_path_buf(), error);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        files.push(entry.map_err(unreadable)?.path());
    }
    files.sort();
    files
        .iter()
        .map(|file| Scenario::load(file).map_err(SuiteError::Scenario))
        .collect()
}
