//! Runs one drawn scenario, and computes its result from the samples.

use super::draw::Obstacle;
use super::failure::{Failed, Failure};
use super::model::margin_mm;
use crate::programs::Programs;
use crate::results::summary::intervenes;
use crate::scenario::Scenario;
use crate::simulator::record::Sample;
use crate::simulator::run::{Inject, Options, run};
use crate::tools::suite::SuiteError;
use serde::{Deserialize, Serialize};
use std::sync::{Arc, Mutex};

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// The robot stands level behind the obstacle.
    Cleared,
    /// Given up, on level ground.
    GivenUp,
    /// Given up, and held where it stands.
    Held,
    /// The robot toppled.
    Toppled,
    /// The guard or the drives stopped the robot where it stands.
    Stopped,
    /// The time was over.
    Unfinished,
}

/// Result of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Seed of the suite.
    pub seed: u64,
    /// Number of the run.
    pub number: u64,
    /// The obstacle, in words.
    pub about: String,
    /// The obstacle.
    pub obstacle: Obstacle,
    /// Margin of the statics, mm.
    pub margin_mm: f64,
    /// What failed.
    pub failed: Option<Failed>,
    /// How it ended.
    pub ending: Ending,
    /// Time from the start of the clearance to the end, s.
    pub time_s: f64,
    /// Number of times that the guard began to intervene.
    pub interventions: u64,
    /// Largest and smallest pitch, and largest roll, degrees.
    pub attitude_deg: [f64; 3],
    /// Smallest margin that the guard published, mm.
    pub least_margin_mm: f64,
    /// Phases with the causes of the transitions to them, and the times, s.
    pub phases: Vec<(f64, String)>,
    /// Verdicts other than "passed", with the times at which they began, s.
    pub verdicts: Vec<(f64, String)>,
    /// Virtual time, s.
    pub simulated_s: f64,
    /// Hash of all states and frames.
    #[serde(default)]
    pub state_hash: String,
}

/// Margin from which the statics must be right, mm.
pub const POSSIBLE_MM: f64 = 20.0;

impl Row {
    /// Whether the robot toppled, or its end is not the right one. If nothing failed, it must clear
    /// an obstacle that it can clear by statics. In any case it must get to an end.
    pub fn missed(&self) -> bool {
        let possible = self.margin_mm >= POSSIBLE_MM && self.failed.is_none();
        matches!(self.ending, Ending::Toppled | Ending::Unfinished)
            || possible && self.ending != Ending::Cleared
    }
}

/// Time for which the robot stands level behind the obstacle, s.
const LEVEL_S: f64 = 1.0;
/// Largest pitch and roll of a level robot, rad.
const LEVEL: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// Distance of the centre of gravity behind the last edge, m.
const BEHIND_M: f64 = 0.1;
/// Time for which a robot that gave up stands still before the run ends, s.
const STILL_S: f64 = 4.0;
/// Largest speed of the belts of a robot that stands still, m/s.
const STILL_MPS: f64 = 0.005;
/// Largest distance by which its centre of gravity moves, m. It may rock on an edge.
const STILL_M: f64 = 0.005;

/// Returns how a run ended, from its last sample.
fn ending(last: &Sample, end_m: f64, duration_s: f64) -> Ending {
    match last.received.clearance {
        _ if last.truth.toppled => Ending::Toppled,
        _ if behind(last, end_m) => Ending::Cleared,
        "given up" => Ending::GivenUp,
        "held" => Ending::Held,
        _ if last.time_s < duration_s - 0.1 => Ending::Stopped,
        _ => Ending::Unfinished,
    }
}

/// Runs one scenario, in which this fails.
///
/// # Errors
/// [`SuiteError::Run`] if the run fails.
pub fn clear(
    scenario: &Scenario,
    obstacle: &Obstacle,
    failure: Option<Failure>,
    programs: &Programs,
) -> Result<Row, SuiteError> {
    let end_m = obstacle.end_m + BEHIND_M;
    let (mut level_since, mut still_since) = (None, None);
    let mut autonomous = false;
    let mut failed = failure.as_ref().map(|failure| Failed {
        phase: failure.phase.name().to_owned(),
        fault: None,
    });
    let began = Arc::new(Mutex::new(None));
    let inject = failure.map(|failure| {
        let (began, mut inject) = (Arc::clone(&began), failure.inject());
        let inject = move |sample: &Sample| {
            let fault = inject(sample)?;
            if let Ok(mut began) = began.lock() {
                *began = Some(fault.clone());
            }
            Some(fault)
        };
        Box::new(inject) as Inject
    });
    let options = Options {
        end_when_toppled: true,
        end_when: Some(Box::new(move |sample| {
            level_since = behind(sample, end_m).then(|| level_since.unwrap_or(sample.time_s));
            autonomous |= !sample.received.clearance.is_empty();
            let (time_s, cog) = (sample.time_s, sample.truth.cog);
            let still = autonomous && belts_stand(sample);
            let rests = still_since.filter(|(_, from)| distance(*from, cog) < STILL_M);
            still_since = still.then(|| rests.unwrap_or((time_s, cog)));
            level_since.is_some_and(|since| sample.time_s - since >= LEVEL_S)
                || still_since.is_some_and(|(since, _)| sample.time_s - since >= STILL_S)
        })),
        inject,
        ..Options::default()
    };
    let outcome = run(scenario, programs, options)
        .map_err(|error| SuiteError::Run(scenario.name.clone(), error))?;
    let samples = &outcome.samples;
    let (mut phases, mut verdicts) = (Vec::new(), Vec::new());
    let mut verdict = String::new();
    let mut interventions = 0;
    let mut attitude = [0.0_f64; 3];
    let mut least_margin = f64::INFINITY;
    let mut began_s = None;
    for sample in samples {
        let received = &sample.received;
        let log = received.events.iter();
        phases.extend(log.filter_map(|event| {
            let text = event.text.strip_prefix("clearance: ")?;
            Some((sample.time_s, text.to_owned()))
        }));
        if began_s.is_none() && !received.clearance.is_empty() {
            began_s = Some(sample.time_s);
        }
        if began_s.is_none() {
            continue;
        }
        if received.verdict != verdict {
            verdict.clone_from(&received.verdict);
            if intervenes(&verdict) {
                interventions += 1;
                verdicts.push((sample.time_s, verdict.clone()));
            }
        }
        attitude[0] = attitude[0].max(sample.truth.pitch.to_degrees());
        attitude[1] = attitude[1].min(sample.truth.pitch.to_degrees());
        attitude[2] = attitude[2].max(sample.truth.roll.abs().to_degrees());
        for margin in received.margins.iter().flatten() {
            least_margin = least_margin.min(*margin);
        }
    }
    let last = samples.last();
    let time_s = last.map_or(0.0, |sample| sample.time_s);
    let ending = last.map_or(Ending::Unfinished, |sample| {
        ending(sample, end_m, scenario.duration_s)
    });
    if let (Some(failed), Ok(mut began)) = (&mut failed, began.lock()) {
        failed.fault = began.take().filter(|fault| fault.at_s < time_s);
    }
    let rounded = |value: f64| (value * 10.0).round() / 10.0;
    Ok(Row {
        seed: 0,
        number: 0,
        about: scenario.about.clone(),
        obstacle: *obstacle,
        margin_mm: rounded(margin_mm(obstacle, &scenario.robot)),
        failed,
        ending,
        time_s: rounded(time_s - began_s.unwrap_or(time_s)),
        interventions,
        attitude_deg: attitude.map(rounded),
        least_margin_mm: rounded(least_margin * 1e3),
        phases,
        verdicts,
        simulated_s: time_s,
        state_hash: outcome.facts.state_hash.clone(),
    })
}

/// Whether the belts stand still.
fn belts_stand(sample: &Sample) -> bool {
    let speeds = sample.truth.belt_speed;
    speeds.iter().all(|speed| speed.abs() < STILL_MPS)
}

fn distance(from: [f64; 3], to: [f64; 3]) -> f64 {
    let squares = from.iter().zip(to).map(|(from, to)| (to - from).powi(2));
    squares.sum::<f64>().sqrt()
}

/// Whether the robot stands level behind the obstacle.
fn behind(sample: &Sample, end_m: f64) -> bool {
    let truth = &sample.truth;
    truth.pitch.abs() < LEVEL && truth.roll.abs() < LEVEL && truth.cog[0] > end_m
}
