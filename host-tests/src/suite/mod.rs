//! `cargo demo --suite hazards`: what the guard saves, and what it must not hinder.
//!
//! A hazard topples without the guard and must not with it, and the guard must leave the operator alone for as long as it
//! can: by trial runs in which the operator lets go, the suite finds the last moment at which that still saves the robot, and
//! says how far before it the guard first acted. A legitimate run must pass unhindered.
//!
//! [`judge`] evaluates one scenario, [`interruption`] one with a restart or a reset, [`draw`] draws scenarios, [`table`] writes the results, and
//! [`operators`] is the suite of operators who command at random, [`command`] runs both as the user
//! commands. Here: the hazard suite, on all cores.

pub mod command;
pub mod draw;
pub mod interruption;
pub mod judge;
pub mod operators;
pub mod table;

use crate::nodes::Programs;
use crate::run::RunError;
use crate::scenario::{Scenario, ScenarioError};
use draw::{Kind, draw};
use judge::{Row, Thoroughness, hazard, legitimate};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::thread;

/// Draws after which a number is given up: its family has no such run.
const MOST_DRAWS: u64 = 20;

/// What came out of the suite.
pub struct Findings {
    /// The scenarios that have files, in the order of their names, hazards first.
    pub named: Vec<Row>,
    /// Seed of the drawn ones.
    pub seed: u64,
    /// The drawn ones, by number, hazards first.
    pub drawn: [Drawn; 2],
}

/// Drawn runs of one kind.
#[derive(Default)]
pub struct Drawn {
    /// One for each number from 0.
    pub rows: Vec<Row>,
    /// Draws that were no runs of the kind and were drawn again.
    pub redrawn: u64,
}

impl Findings {
    /// Every row.
    pub fn rows(&self) -> impl Iterator<Item = &Row> {
        let drawn = self.drawn.iter().flat_map(|drawn| &drawn.rows);
        self.named.iter().chain(drawn)
    }

    /// Whether every row holds.
    pub fn all_hold(&self) -> bool {
        self.rows().all(|row| row.unmet.is_empty())
    }
}

/// Why the suite could not be run.
#[derive(Debug)]
pub enum SuiteError {
    /// A folder cannot be read.
    Folder(PathBuf, std::io::Error),
    /// A scenario is bad.
    Scenario(ScenarioError),
    /// A run broke.
    Run(String, RunError),
}

impl fmt::Display for SuiteError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Folder(path, error) => write!(f, "cannot read {}: {error}", path.display()),
            Self::Scenario(error) => write!(f, "{error}"),
            Self::Run(name, error) => write!(f, "{name}: {error}"),
        }
    }
}

impl std::error::Error for SuiteError {}

/// Runs all scenarios of `folder`/hazards and `folder`/legitimate, then `random` drawn ones of each kind; `done` is told of each
/// row as it comes.
///
/// # Errors
/// [`SuiteError`] of the first scenario that cannot be run.
pub fn suite(
    folder: &Path,
    random: u64,
    seed: u64,
    programs: &Programs,
    done: &(dyn Fn(&Row) + Sync),
) -> Result<Findings, SuiteError> {
    let mut work = Vec::new();
    for kind in Kind::ALL {
        let scenarios = scenarios(&folder.join(kind.folder()))?;
        work.extend(scenarios.into_iter().map(|scenario| (kind, scenario)));
    }
    let named = on_all_cores(&work, |(kind, scenario)| {
        let row = judged(*kind, scenario, Thoroughness::Full, programs)?;
        done(&row);
        Ok(row)
    })?;
    let mut drawn = [const { None }; 2];
    for (place, kind) in drawn.iter_mut().zip(Kind::ALL) {
        *place = Some(drawn_runs(kind, random, seed, programs, done)?);
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
    programs: &Programs,
    done: &(dyn Fn(&Row) + Sync),
) -> Result<Drawn, SuiteError> {
    let numbers: Vec<u64> = (0..count).collect();
    let rows = on_all_cores(&numbers, |number| {
        let (mut again, mut simulated_s) = (0, 0.0);
        loop {
            let scenario = draw(kind, seed, *number, again).map_err(SuiteError::Scenario)?;
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

/// What `job` makes of each item, in their order.
fn on_all_cores<T: Sync, R: Send>(
    work: &[T],
    job: impl Fn(&T) -> Result<R, SuiteError> + Sync,
) -> Result<Vec<R>, SuiteError> {
    let next = Mutex::new(work.iter().enumerate());
    let results = Mutex::new(Vec::new());
    let cores = thread::available_parallelism().map_or(1, std::num::NonZero::get);
    thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| {
                loop {
                    let taken = next.lock().ok().and_then(|mut next| next.next());
                    let Some((index, item)) = taken else { return };
                    let result = job(item);
                    if let Ok(mut results) = results.lock() {
                        results.push((index, result));
                    }
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_default();
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}
