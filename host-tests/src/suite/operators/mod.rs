//! `cargo demo --suite operators`: an operator who commands at random must not topple the robot on
//! fair ground.
//!
//! [`edges`] decides what is fair ground, [`journal`] keeps each result as soon as it is there, and
//! [`table`] writes the table. `suite::draw::operators` draws the runs. Here: one run, and all of them
//! on all cores.

pub mod edges;
pub mod journal;
pub mod table;

use super::draw::operators::draw;
use super::{SuiteError, on_all_cores};
use crate::machines::Kind;
use crate::nodes::{Programs, hexadecimal};
use crate::record::Sample;
use crate::run::{Options, Outcome, run};
use crate::scenario::Scenario;
use edges::Edges;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Draws after which a number is given up: every one toppled before the operator commanded anything.
const MAXIMUM_DRAWS: u64 = 20;

/// What is run.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// The robot.
    pub robot: Kind,
    /// Whether the guard's filter is on.
    pub guard: bool,
    /// Number of runs.
    pub runs: u64,
    /// Seed of all of them.
    pub seed: u64,
}

/// Where and how a robot turned over.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Topple {
    /// Virtual time, s.
    pub time_s: f64,
    /// It fell over an edge that is no fair ground.
    pub over_edge: bool,
    /// Pitch, roll and chassis angle one second before, degrees.
    pub attitude_deg: [f64; 3],
    /// Speed, m/s, and chassis angle, degrees, that were commanded one second before.
    pub commanded: [f64; 2],
    /// What the guard said one second before.
    pub verdict: String,
}

/// Number of commands by what became of them until the next; those while the robot was armed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Commands {
    /// Passed as they were.
    pub passed: u64,
    /// Scaled at some time.
    pub scaled: u64,
    /// Refused at some time.
    pub refused: u64,
}

/// Result of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Seed of the suite.
    pub seed: u64,
    /// Number of the run.
    pub number: u64,
    /// Draws before that toppled before the operator commanded anything.
    pub drawn_again: u64,
    /// SHA-256 of the scenario file.
    pub scenario: String,
    /// SHA-256 of the programs.
    pub programs: String,
    /// Ground and load.
    pub about: String,
    /// The robot turned over.
    pub topple: Option<Topple>,
    /// It was armed at some time.
    pub armed: bool,
    /// Share of the time since it was first armed during which it was.
    pub armed_share: f64,
    /// Distance that it drove, forward and backward, m.
    pub distance_m: f64,
    /// What became of the commands.
    pub commands: Commands,
    /// Virtual time, that of draws before included, s.
    pub simulated_s: f64,
}

impl Row {
    /// Whether the robot turned over where it must not.
    pub fn failed(&self) -> bool {
        self.topple.as_ref().is_some_and(|topple| !topple.over_edge)
    }
}

/// Makes the runs of `plan` that are not among `known`; `done` receives each with its scenario. The
/// result has all of them by number.
///
/// # Errors
/// [`SuiteError`] of the first run that breaks.
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

/// The scenario of a run.
///
/// # Errors
/// [`SuiteError::Scenario`] when it is out of bounds.
pub fn drawn(plan: &Plan, number: u64, again: u64) -> Result<Scenario, SuiteError> {
    draw(plan.robot, plan.guard, plan.seed, number, again).map_err(SuiteError::Scenario)
}

/// A known result of this very run with these very programs.
fn reusable(
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

fn fingerprint(text: &str) -> String {
    hexadecimal(&Sha256::digest(text))
}

fn of_programs(programs: &Programs) -> String {
    let all = [&programs.axle, &programs.screw, &programs.guard];
    fingerprint(&all.map(|program| program.sha256.as_str()).concat())
}

/// Runs one scenario; also whether the operator commanded anything.
///
/// # Errors
/// [`SuiteError::Run`] when the run breaks.
pub fn operate(scenario: &Scenario, programs: &Programs) -> Result<(Row, bool), SuiteError> {
    let options = Options {
        end_when_toppled: true,
        ..Options::default()
    };
    let outcome = run(scenario, programs, options, &mut |_| {})
        .map_err(|error| SuiteError::Run(scenario.name.clone(), error))?;
    let samples = &outcome.samples;
    let armed_s = outcome.commands_s.first().copied();
    let topple = topple(scenario, samples);
    let operated = samples
        .iter()
        .skip_while(|sample| !is_armed(sample))
        .count();
    let armed = samples.iter().filter(|sample| is_armed(sample)).count();
    let commanded = armed_s.is_some_and(|armed| {
        let toppled_s = topple
            .as_ref()
            .map_or(f64::INFINITY, |topple| topple.time_s);
        armed < toppled_s
    });
    let row = Row {
        seed: 0,
        number: 0,
        drawn_again: 0,
        scenario: fingerprint(&text(scenario)),
        programs: of_programs(programs),
        about: scenario.about.clone(),
        topple,
        armed: armed > 0,
        armed_share: armed as f64 / operated.max(1) as f64,
        distance_m: distance_m(samples),
        commands: commands(&outcome),
        simulated_s: samples.last().map_or(0.0, |sample| sample.time_s),
    };
    Ok((row, commanded))
}

fn is_armed(sample: &Sample) -> bool {
    sample.heard.guard_state == "armed"
}

fn distance_m(samples: &[Sample]) -> f64 {
    let period = 1.0 / f64::from(crate::record::SAMPLE_HZ);
    let upright = samples.iter().take_while(|sample| !sample.truth.toppled);
    upright
        .map(|sample| sample.truth.ground_speed.abs() * period)
        .sum()
}

fn topple(scenario: &Scenario, samples: &[Sample]) -> Option<Topple> {
    let mut edges = Edges::of(scenario);
    for sample in samples {
        edges.follow(sample.time_s, &sample.truth);
        if !sample.truth.toppled {
            continue;
        }
        let early = |before: &&Sample| before.time_s <= sample.time_s - 1.0;
        let before = samples.iter().take_while(early).last().unwrap_or(sample);
        let (truth, heard) = (&before.truth, &before.heard);
        let rounded = |value: f64| (value * 10.0).round() / 10.0;
        let degrees = |radians: f64| rounded(radians.to_degrees());
        return Some(Topple {
            time_s: sample.time_s,
            over_edge: edges.falling(),
            attitude_deg: [truth.pitch, truth.roll, truth.theta].map(degrees),
            commanded: [heard.asked_speed, degrees(heard.asked_theta)],
            verdict: heard.verdict.clone(),
        });
    }
    None
}

/// What became of each command until the next one.
fn commands(outcome: &Outcome) -> Commands {
    let mut commands = Commands::default();
    let times = &outcome.commands_s;
    for (index, from_s) in times.iter().enumerate() {
        let until_s = times.get(index + 1).copied().unwrap_or(f64::INFINITY);
        let meanwhile = outcome.samples.iter().filter(|sample| {
            is_armed(sample) && sample.time_s > *from_s && sample.time_s <= until_s
        });
        let verdicts: Vec<&str> = meanwhile
            .map(|sample| sample.heard.verdict.as_str())
            .collect();
        if verdicts
            .iter()
            .any(|verdict| verdict.starts_with("refused"))
        {
            commands.refused += 1;
        } else if verdicts.iter().any(|verdict| *verdict != "passed") {
            commands.scaled += 1;
        } else if !verdicts.is_empty() {
            commands.passed += 1;
        }
    }
    commands
}
