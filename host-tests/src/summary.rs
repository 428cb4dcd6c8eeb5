//! What came out of a run, in figures. `expectation` compares it with what the scenario expects, `notes` explains it, `landing` finds the landing, `table` prints it.

mod expectation;
mod landing;
mod notes;
mod table;

use crate::balance::{Balance, Figures};
use crate::machines::Kind;
use crate::record::{SAMPLE_HZ, Sample};
use crate::report::channels::Channel;
use crate::scenario::{NodeName, Scenario};
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use tautrack::link::STEP_US;

use landing::landing;

/// The climb begins when the pitch first exceeds this, rad.
const CLIMBING: f64 = 8.0 * std::f64::consts::PI / 180.0;
/// Slower than this on average over the last second is standing still, m/s.
const STANDING_MPS: f64 = 0.01;

/// What a run comes to is its mean over the last so many seconds.
pub const SETTLED_S: u32 = 5;

/// What only the runner knows.
#[derive(Clone, Debug, Default)]
pub struct RunFacts {
    /// Wall-clock time from the first step to the last, s.
    pub wall_s: f64,
    /// Lockstep steps done.
    pub steps: u64,
    /// The nodes, in the order in which they were started.
    pub nodes: Vec<NodeFacts>,
    /// Frames that the bus delivered.
    pub frames: u64,
    /// Longest time that a frame waited for the bus, ms.
    pub worst_latency_ms: f64,
    /// What became of the scenario's faults, in its order.
    pub faults: Vec<FaultFacts>,
    /// Hash over all truth bits and delivered frames of every step, hexadecimal.
    pub state_hash: String,
}

/// One node of a run.
#[derive(Clone, Debug, Serialize)]
pub struct NodeFacts {
    /// Name in the robot.
    pub name: NodeName,
    /// Role of the program: `axle`, `screw` or `guard`.
    pub role: String,
    /// Board of the program: `mps2` or `native`.
    pub board: String,
    /// `CANopen` node id.
    pub node_id: u8,
    /// SHA-256 of the program file, hexadecimal.
    pub program_sha256: String,
}

/// What became of one fault.
#[derive(Clone, Debug, Serialize)]
pub struct FaultFacts {
    /// Virtual time at which it began, s.
    pub time_s: f64,
    /// The node it befell, if it was one.
    pub node: Option<NodeName>,
    /// What it was, a few words.
    pub what: String,
    /// Who said so on the bus first; absent when nobody did.
    pub noticed_by: Option<String>,
    /// How long that took, ms.
    pub after_ms: Option<f64>,
}

/// SHA-256 of a program file in hexadecimal.
///
/// # Errors
/// When the file cannot be read.
pub fn fingerprint(program: &Path) -> std::io::Result<String> {
    let digest = Sha256::digest(std::fs::read(program)?);
    Ok(digest
        .iter()
        .fold(String::new(), |text, byte| text + &format!("{byte:02x}")))
}

/// The figures of one run; serialises to `summary.json`.
#[derive(Clone, Debug, Serialize)]
#[allow(clippy::struct_excessive_bools)] // independent findings, not states
pub struct Summary {
    /// Name of the scenario.
    pub scenario: String,
    /// Seed of all noise and random faults.
    pub seed: u64,
    /// Whether everything that the scenario expects came true.
    pub expectation_met: bool,
    /// What did not, one sentence each.
    pub unmet: Vec<String>,
    /// Why the run ended before its time; absent if it did not.
    pub ended_early: Option<String>,
    /// Number of CAN clients that took part.
    pub clients: usize,
    /// Stood level behind the last nose.
    pub landed: bool,
    /// Turned over.
    pub toppled: bool,
    /// Virtual time from which it stood so, s.
    pub landing_time_s: Option<f64>,
    /// Stood still during the last second.
    pub stopped: bool,
    /// Virtual time of the run, s.
    pub simulated_s: f64,
    /// Wall-clock time of the run, s.
    pub wall_s: f64,
    /// Virtual over wall-clock time.
    pub realtime_factor: f64,
    /// Lockstep steps.
    pub steps: u64,
    /// `|L + L2 + L3 - K|` by the plant's truth, from the first pitch above 8 degrees to the landing or the end; of B2P2 alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tension_error_m: Option<TensionError>,
    /// Distance over ground, forward and backward added, by the plant's truth, m.
    pub driven_m: f64,
    /// Pitch by the plant's truth, degrees.
    pub pitch_deg: Range,
    /// Least horizontal distance from the rearmost contact to the centre of gravity, by the plant's truth, m; absent for
    /// a robot whose margin is a channel of its own.
    pub min_backward_margin_m: Option<f64>,
    /// Least margin to any edge by the guard's estimate while it drives, m; absent when it had none.
    pub min_guard_margin_m: Option<f64>,
    /// How far the zero moment point went from the centre of gravity during the climb, as in Fig. 8 of Paillat et al.; absent without one.
    pub zero_moment_point: Option<Figures>,
    /// What only this robot has, by name; the unit is in the name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub channels: BTreeMap<&'static str, ChannelFigures>,
    /// Those of them that are worth a line.
    #[serde(skip)]
    pub headlines: &'static [&'static str],
    /// What the guard did.
    pub guard: GuardFigures,
    /// Sentences about figures that need an explanation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// How the bus fared.
    pub bus: BusFigures,
    /// What went wrong on purpose.
    pub faults: Vec<FaultFacts>,
    /// The nodes.
    pub nodes: Vec<NodeFacts>,
    /// Hash over all truth bits and delivered frames of every step, hexadecimal.
    pub state_hash: String,
}

/// Strain or slack of the belt; zero when the run never climbed.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct TensionError {
    /// 99 % of the samples are at most this.
    pub p99: f64,
    /// Largest.
    pub max: f64,
}

/// Least and largest value.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Range {
    /// Least.
    pub min: f64,
    /// Largest.
    pub max: f64,
}

/// One channel of [`crate::record::Truth::channels`].
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct ChannelFigures {
    /// Least.
    pub min: f64,
    /// Largest.
    pub max: f64,
    /// Mean over the last [`SETTLED_S`].
    pub settled: f64,
}

/// What the guard did with the operator's commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct GuardFigures {
    /// Times that it began to do anything but pass a command on as asked.
    pub interventions: usize,
    /// Those in which it refused.
    pub refused: usize,
    /// Those in which it passed on less than asked.
    pub scaled: usize,
}

/// How the bus fared.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct BusFigures {
    /// Largest load over 100 ms, 0 to 1.
    pub load_max: f64,
    /// Mean load, 0 to 1.
    pub load_mean: f64,
    /// Frames delivered.
    pub frames: u64,
    /// Longest time that a frame waited, ms.
    pub worst_latency_ms: f64,
}

impl Summary {
    /// Computes all figures. Samples are in order of time, [`SAMPLE_HZ`] a second; none at all gives a summary of zeros.
    pub fn new(scenario: &Scenario, facts: &RunFacts, samples: &[Sample]) -> Self {
        let landing = landing(scenario, samples);
        let climb = climb(scenario, samples);
        let is_b2p2 = scenario.kind() == Kind::B2p2;
        let simulated_s = (facts.steps * STEP_US) as f64 / 1e6;
        let loads = || samples.iter().map(|sample| sample.heard.bus_load);
        let mut summary = Self {
            scenario: scenario.name.clone(),
            seed: scenario.seed,
            expectation_met: false,
            unmet: Vec::new(),
            ended_early: None,
            clients: 0,
            notes: Vec::new(),
            landed: landing.is_some(),
            toppled: samples.iter().any(|sample| sample.truth.toppled),
            landing_time_s: landing.map(|index| samples[index].time_s),
            stopped: stopped(samples),
            simulated_s,
            wall_s: facts.wall_s,
            realtime_factor: if facts.wall_s > 0.0 {
                simulated_s / facts.wall_s
            } else {
                0.0
            },
            steps: facts.steps,
            tension_error_m: is_b2p2.then(|| tension_error(&samples[climb])),
            driven_m: path(samples) / f64::from(SAMPLE_HZ),
            pitch_deg: range(samples.iter().map(|sample| sample.truth.pitch.to_degrees())),
            min_backward_margin_m: samples
                .iter()
                .filter_map(|sample| sample.truth.backward_margin)
                .reduce(f64::min),
            min_guard_margin_m: notes::guard_margin(samples),
            zero_moment_point: is_b2p2
                .then(|| Balance::new(scenario, samples).figures)
                .flatten(),
            channels: channels(samples),
            headlines: scenario.kind().headlines(),
            guard: guard_figures(samples.iter().map(|sample| sample.heard.verdict.as_str())),
            bus: BusFigures {
                load_max: loads().fold(0.0, f64::max),
                load_mean: loads().sum::<f64>() / samples.len().max(1) as f64,
                frames: facts.frames,
                worst_latency_ms: facts.worst_latency_ms,
            },
            faults: facts.faults.clone(),
            nodes: facts.nodes.clone(),
            state_hash: facts.state_hash.clone(),
        };
        summary.unmet = summary.unmet_expectations(scenario);
        summary.notes = summary.explanations(scenario);
        summary.expectation_met = summary.unmet.is_empty();
        summary
    }

    /// Marks the run as one that ended before its time; what its scenario expects is then not met.
    pub fn end_early(&mut self, why: &str) {
        self.unmet.push(format!("The run ended early: {why}."));
        self.expectation_met = false;
        self.ended_early = Some(why.to_owned());
    }

    /// The channels that are worth a line, with what they are.
    pub fn headlines(&self) -> impl Iterator<Item = (Channel, ChannelFigures)> {
        let found = |name: &&str| Some((Channel::new(name), *self.channels.get(*name)?));
        self.headlines.iter().filter_map(found)
    }
}

/// The samples from the first nose to the landing, or to the end; none when the robot never climbed.
pub(crate) fn climb(scenario: &Scenario, samples: &[Sample]) -> std::ops::Range<usize> {
    let end = landing(scenario, samples).unwrap_or(samples.len());
    let start = samples[..end]
        .iter()
        .position(|sample| sample.truth.pitch > CLIMBING);
    start.unwrap_or(end)..end
}

fn stopped(samples: &[Sample]) -> bool {
    let last = &samples[samples.len().saturating_sub(SAMPLE_HZ as usize)..];
    !last.is_empty() && path(last) / (last.len() as f64) < STANDING_MPS
}

/// Sum of the speeds over ground.
fn path(samples: &[Sample]) -> f64 {
    let speeds = samples.iter().map(|sample| sample.truth.ground_speed.abs());
    speeds.sum()
}

fn tension_error(climb: &[Sample]) -> TensionError {
    let mut errors: Vec<f64> = climb
        .iter()
        .map(|sample| sample.truth.tension_error.abs())
        .collect();
    errors.sort_by(f64::total_cmp);
    TensionError {
        p99: percentile(&errors, 99),
        max: errors.last().copied().unwrap_or_default(),
    }
}

/// Nearest-rank percentile: the least value that at least `percent` % of the values do not exceed; 0 of nothing.
/// `sorted` ascends; `percent` is 0 to 100, and whole, because 0.28 x 25 is above 7 in binary.
pub fn percentile(sorted: &[f64], percent: usize) -> f64 {
    let rank = (percent * sorted.len()).div_ceil(100).max(1);
    sorted
        .get(rank - 1)
        .or(sorted.last())
        .copied()
        .unwrap_or_default()
}

fn channels(samples: &[Sample]) -> BTreeMap<&'static str, ChannelFigures> {
    let last = samples
        .len()
        .saturating_sub((SETTLED_S * SAMPLE_HZ) as usize);
    let keys = samples
        .iter()
        .flat_map(|sample| sample.truth.channels.keys());
    let names: BTreeSet<&'static str> = keys.copied().collect();
    let of = |name: &'static str| {
        let values = |from: usize| {
            samples[from..]
                .iter()
                .filter_map(move |sample| sample.truth.channels.get(name).copied())
        };
        let Range { min, max } = range(values(0));
        let settled = values(last).sum::<f64>() / values(last).count().max(1) as f64;
        (name, ChannelFigures { min, max, settled })
    };
    names.into_iter().map(of).collect()
}

fn range(values: impl Iterator<Item = f64>) -> Range {
    values
        .map(|value| Range {
            min: value,
            max: value,
        })
        .reduce(|a, b| Range {
            min: a.min.min(b.min),
            max: a.max.max(b.max),
        })
        .unwrap_or_default()
}

/// What a verdict does, without its reason: `scaled` of `scaled: backward margin`.
pub(crate) fn verdict_kind(verdict: &str) -> &str {
    verdict.split(':').next().unwrap_or_default().trim()
}

/// Whether a verdict changes a command; before the guard speaks there is none.
pub(crate) fn intervenes(verdict: &str) -> bool {
    !matches!(verdict_kind(verdict), "" | "passed")
}

/// A number of things, as a sentence has it: `1 intervention`, `2 interventions`.
pub(crate) fn counted(count: usize, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

fn guard_figures<'a>(verdicts: impl Iterator<Item = &'a str>) -> GuardFigures {
    let mut figures = GuardFigures::default();
    let mut before = "";
    for kind in verdicts.map(verdict_kind) {
        if kind != before && intervenes(kind) {
            figures.interventions += 1;
            figures.refused += usize::from(kind == "refused");
            figures.scaled += usize::from(kind == "scaled");
        }
        before = kind;
    }
    figures
}
