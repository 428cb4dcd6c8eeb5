//! `cargo demo --suite hazards`: what the guard saves, and what it must not hinder.
//!
//! A hazard topples without the guard and must not with it, and the guard must leave the operator alone for as long as it
//! can: by trial runs in which the operator lets go, the suite finds the last moment at which that still saves the robot, and
//! says how far before it the guard first acted. A legitimate run must pass unhindered.

use crate::nodes::Programs;
use crate::record::Sample;
use crate::run::{Options, RunError, run};
use crate::scenario::{Scenario, ScenarioError};
use crate::summary::intervenes;
use std::fmt::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::thread;

/// Farthest that the guard may act before the robot is beyond saving, m and s; one of the two must hold.
const EARLIEST_M: f64 = 0.25;
const EARLIEST_S: f64 = 1.0;
/// Largest loss of way that a legitimate run may suffer.
const LARGEST_LOSS: f64 = 0.05;
/// To what the last saving moment is found, s.
const RESOLUTION_S: f64 = 0.1;

/// Result of one scenario.
pub struct Row {
    /// Name of the scenario.
    pub name: String,
    /// What came out.
    pub finding: Finding,
    /// What was asked for and did not come true; empty when all did.
    pub unmet: Vec<&'static str>,
}

/// What came out of one scenario.
pub enum Finding {
    /// A hazard.
    Hazard {
        /// When it toppled without the guard, s.
        toppled_s: Option<f64>,
        /// Toppled with the guard as well.
        toppled_with_guard: bool,
        /// When the guard first held back, s.
        acted_s: Option<f64>,
        /// Last moment at which letting go saves the robot, s.
        savable_until_s: f64,
        /// Way of the belts between the two, m; negative when the guard acted later.
        lead_m: f64,
    },
    /// A legitimate run.
    Legitimate {
        /// Way of the belts without the guard, m.
        way_m: f64,
        /// Share of it that was lost with the guard.
        loss: f64,
        /// Times that the guard held back.
        interventions: usize,
    },
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

/// Runs all scenarios of `folder`/hazards and `folder`/legitimate on all cores, in the order of their names; `done` is
/// told of each row as it comes.
///
/// # Errors
/// [`SuiteError`] of the first scenario that cannot be run.
pub fn suite(
    folder: &Path,
    programs: &Programs,
    done: &(dyn Fn(&Row) + Sync),
) -> Result<Vec<Row>, SuiteError> {
    let mut work = Vec::new();
    for (kind, judge) in [
        ("hazards", hazard as Judge),
        ("legitimate", legitimate as Judge),
    ] {
        work.extend(
            scenarios(&folder.join(kind))?
                .into_iter()
                .map(|scenario| (scenario, judge)),
        );
    }
    let next = Mutex::new(work.iter().enumerate());
    let rows = Mutex::new(Vec::new());
    let cores = thread::available_parallelism().map_or(1, std::num::NonZero::get);
    thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| {
                loop {
                    let taken = next.lock().ok().and_then(|mut next| next.next());
                    let Some((index, (scenario, judge))) = taken else {
                        return;
                    };
                    let row = judge(scenario, programs);
                    if let Ok(row) = &row {
                        done(row);
                    }
                    if let Ok(mut rows) = rows.lock() {
                        rows.push((index, row));
                    }
                }
            });
        }
    });
    let mut rows = rows.into_inner().unwrap_or_default();
    rows.sort_by_key(|(index, _)| *index);
    rows.into_iter().map(|(_, row)| row).collect()
}

type Judge = fn(&Scenario, &Programs) -> Result<Row, SuiteError>;

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

/// Samples of `scenario` with the guard on or off, and the operator letting go at a time, if at all.
fn samples(
    scenario: &Scenario,
    programs: &Programs,
    guard: bool,
    let_go_s: Option<f64>,
) -> Result<Vec<Sample>, SuiteError> {
    let name = || scenario.name.clone();
    let mut description = scenario.description();
    description.guard = guard;
    let checked = Scenario::checked(description).map_err(SuiteError::Scenario)?;
    let options = Options {
        let_go_s,
        end_when_toppled: true,
        ..Options::default()
    };
    let outcome = run(&checked, programs, options, &mut |_| {})
        .map_err(|error| SuiteError::Run(name(), error))?;
    Ok(outcome.samples)
}

fn toppled_s(samples: &[Sample]) -> Option<f64> {
    samples
        .iter()
        .find(|sample| sample.truth.toppled)
        .map(|sample| sample.time_s)
}

fn hazard(scenario: &Scenario, programs: &Programs) -> Result<Row, SuiteError> {
    let without = samples(scenario, programs, false, None)?;
    let with = samples(scenario, programs, true, None)?;
    let acted = with.iter().find(|sample| intervenes(&sample.heard.verdict));
    let toppled = toppled_s(&without);
    let savable_until_s = match toppled {
        Some(toppled) => savable_until(scenario, programs, toppled)?,
        None => scenario.duration_s,
    };
    let way_at = |time_s: f64| {
        without
            .iter()
            .take_while(|sample| sample.time_s <= time_s)
            .last()
            .map_or(0.0, |sample| sample.heard.odometry)
    };
    let acted_s = acted.map(|sample| sample.time_s);
    let lead_m = acted_s.map_or(0.0, |acted| way_at(savable_until_s) - way_at(acted));
    let lead_s = acted_s.map_or(0.0, |acted| savable_until_s - acted);
    let toppled_with_guard = toppled_s(&with).is_some();
    let mut unmet = Vec::new();
    for (bad, what) in [
        (
            toppled.is_none(),
            "no hazard: it does not topple without the guard",
        ),
        (toppled_with_guard, "topples with the guard"),
        (
            lead_m > EARLIEST_M && lead_s > EARLIEST_S,
            "the guard acts too early",
        ),
    ] {
        if bad {
            unmet.push(what);
        }
    }
    let finding = Finding::Hazard {
        toppled_s: toppled,
        toppled_with_guard,
        acted_s,
        savable_until_s,
        lead_m,
    };
    Ok(Row {
        name: scenario.name.clone(),
        finding,
        unmet,
    })
}

/// The last moment before `toppled_s` at which the robot does not topple when the operator lets go, by bisection.
fn savable_until(
    scenario: &Scenario,
    programs: &Programs,
    toppled_s: f64,
) -> Result<f64, SuiteError> {
    let (mut saves, mut fails) = (0.0, toppled_s);
    // Letting go long before is the same as never having come: start near the end.
    let mut probe = (toppled_s - 2.0).max(0.0);
    while fails - saves > RESOLUTION_S {
        if toppled_s_after_letting_go(scenario, programs, probe)?.is_some() {
            fails = probe;
        } else {
            saves = probe;
        }
        probe = if saves == 0.0 {
            (fails - 2.0).max(0.0)
        } else {
            0.5 * (saves + fails)
        };
        if fails <= RESOLUTION_S {
            break;
        }
    }
    Ok(saves)
}

fn toppled_s_after_letting_go(
    scenario: &Scenario,
    programs: &Programs,
    time_s: f64,
) -> Result<Option<f64>, SuiteError> {
    Ok(toppled_s(&samples(
        scenario,
        programs,
        false,
        Some(time_s),
    )?))
}

fn legitimate(scenario: &Scenario, programs: &Programs) -> Result<Row, SuiteError> {
    let without = samples(scenario, programs, false, None)?;
    let with = samples(scenario, programs, true, None)?;
    let way = |samples: &[Sample]| samples.last().map_or(0.0, |sample| sample.heard.odometry);
    let (way_m, way_with_m) = (way(&without), way(&with));
    let loss = if way_m.abs() > 0.01 {
        1.0 - way_with_m / way_m
    } else {
        0.0
    };
    let mut interventions = 0;
    let mut before = false;
    for sample in &with {
        let now = intervenes(&sample.heard.verdict);
        interventions += usize::from(now && !before);
        before = now;
    }
    let mut unmet = Vec::new();
    for (bad, what) in [
        (toppled_s(&without).is_some(), "topples without the guard"),
        (toppled_s(&with).is_some(), "topples with the guard"),
        (loss > LARGEST_LOSS, "slower than allowed"),
        (
            with.iter()
                .any(|sample| sample.heard.verdict.starts_with("refused")),
            "refused",
        ),
    ] {
        if bad {
            unmet.push(what);
        }
    }
    Ok(Row {
        name: scenario.name.clone(),
        finding: Finding::Legitimate {
            way_m,
            loss,
            interventions,
        },
        unmet,
    })
}

/// The rows as two Markdown tables.
pub fn table(rows: &[Row]) -> String {
    let seconds = |time_s: Option<f64>| {
        time_s.map_or_else(|| "never".into(), |time_s| format!("{time_s:.1} s"))
    };
    let verdict = |row: &Row| {
        if row.unmet.is_empty() {
            "holds".into()
        } else {
            row.unmet.join(", ")
        }
    };
    let mut text = String::from(
        "| hazard | topples without | with the guard | guard acts | letting go saves until | lead | |\n|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        if let Finding::Hazard {
            toppled_s,
            toppled_with_guard,
            acted_s,
            savable_until_s,
            lead_m,
        } = &row.finding
        {
            let with = if *toppled_with_guard {
                "topples"
            } else {
                "stands"
            };
            let (without, acted) = (seconds(*toppled_s), seconds(*acted_s));
            let _ = writeln!(
                text,
                "| {} | {without} | {with} | {acted} | {savable_until_s:.1} s | {:.0} mm | {} |",
                row.name,
                lead_m * 1e3,
                verdict(row)
            );
        }
    }
    text.push_str("\n| legitimate run | way | lost with the guard | interventions | |\n|---|---|---|---|---|\n");
    for row in rows {
        if let Finding::Legitimate {
            way_m,
            loss,
            interventions,
        } = &row.finding
        {
            let _ = writeln!(
                text,
                "| {} | {way_m:.2} m | {:.1} % | {interventions} | {} |",
                row.name,
                loss * 100.0,
                verdict(row)
            );
        }
    }
    text
}
