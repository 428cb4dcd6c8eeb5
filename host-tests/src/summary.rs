//! What came out of a run, in figures, and whether it is what the scenario expects.

use crate::record::{SAMPLE_HZ, Sample};
use crate::scenario::{NodeName, Scenario};
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::fmt;
use std::path::Path;

/// A robot counts as landed behind the last nose when it stays this level, rad.
const LEVEL: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// How long it must stay so, samples.
const LEVEL_SAMPLES: usize = SAMPLE_HZ as usize / 2;
/// The climb begins when the pitch first exceeds this, rad.
const CLIMBING: f64 = 8.0 * std::f64::consts::PI / 180.0;
/// Slower than this on average over the last second is standing still, m/s.
const STANDING_MPS: f64 = 0.01;

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
    Ok(digest.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// The figures of one run; serialises to `summary.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Name of the scenario.
    pub scenario: String,
    /// Seed of all noise and random faults.
    pub seed: u64,
    /// Whether everything that the scenario expects came true.
    pub expectation_met: bool,
    /// What did not, one sentence each.
    pub unmet: Vec<String>,
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
    /// `|L + L2 + L3 - K|` by the plant's truth, from the first pitch above 8 degrees to the landing or the end.
    pub tension_error_m: TensionError,
    /// Pitch by the plant's truth, degrees.
    pub pitch_deg: Range,
    /// Least horizontal distance from the rearmost contact to the centre of gravity, by the plant's truth, m.
    pub min_backward_margin_m: Option<f64>,
    /// What the guard did.
    pub guard: GuardFigures,
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
        let climb = climb(samples, landing);
        let simulated_s = samples.last().map_or(0.0, |sample| sample.time_s);
        let loads = || samples.iter().map(|sample| sample.heard.bus_load);
        let mut summary = Self {
            scenario: scenario.name.clone(),
            seed: scenario.seed,
            expectation_met: false,
            unmet: Vec::new(),
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
            tension_error_m: tension_error(climb),
            pitch_deg: range(samples.iter().map(|sample| sample.truth.pitch.to_degrees())),
            min_backward_margin_m: samples
                .iter()
                .filter_map(|sample| sample.truth.backward_margin)
                .reduce(f64::min),
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
        summary.expectation_met = summary.unmet.is_empty();
        summary
    }

    /// What the scenario expects and did not come true, one sentence each.
    pub fn unmet_expectations(&self, scenario: &Scenario) -> Vec<String> {
        let expect = &scenario.expect;
        let mut unmet = Vec::new();
        let mut outcome = |expected: Option<bool>, got: bool, positive: &str, negative: &str| {
            if expected.is_some_and(|expected| expected != got) {
                let (wanted, found) = if got {
                    (negative, positive)
                } else {
                    (positive, negative)
                };
                unmet.push(format!("The robot {found}; expected: {wanted}."));
            }
        };
        outcome(expect.landed, self.landed, "landed", "did not land");
        outcome(expect.toppled, self.toppled, "toppled", "did not topple");
        outcome(
            expect.stopped,
            self.stopped,
            "stood still at the end",
            "was moving at the end",
        );
        if let (Some([from, to]), Some(time)) = (expect.landing_between_s, self.landing_time_s)
            && !(from..=to).contains(&time)
        {
            unmet.push(format!(
                "The robot landed at {time:.2} s; expected: between {from} and {to} s."
            ));
        }
        let interventions = self.guard.interventions;
        if expect
            .guard_intervenes
            .is_some_and(|expected| expected != (interventions > 0))
        {
            let expected = if interventions > 0 {
                "none"
            } else {
                "at least one"
            };
            unmet.push(format!(
                "The guard intervened {interventions} times; expected: {expected}."
            ));
        }
        if let Some(bound) = expect.tension_error_below_m
            && self.tension_error_m.max >= bound
        {
            let got = self.tension_error_m.max * 1e3;
            unmet.push(format!(
                "The belt was off by {got:.2} mm; expected: less than {} mm.",
                bound * 1e3
            ));
        }
        for (index, fault) in scenario.faults.iter().enumerate() {
            let Some(limit) = fault.notice_within_ms else {
                continue;
            };
            let what = fault.what.node().map_or(fault.what.words(), |node| {
                format!("{}: {node}", fault.what.words())
            });
            match self.faults.get(index).and_then(|facts| facts.after_ms) {
                Some(after) if after <= limit => {}
                Some(after) => unmet.push(format!(
                    "Fault \"{what}\" was noticed after {after:.0} ms; expected: {limit} ms."
                )),
                None => unmet.push(format!(
                    "Fault \"{what}\" was never noticed; expected: within {limit} ms."
                )),
            }
        }
        unmet
    }
}

/// First sample of a level stand behind the last nose.
fn landing(scenario: &Scenario, samples: &[Sample]) -> Option<usize> {
    let nose = scenario.terrain.last_nose_m()?;
    let level = |sample: &Sample| {
        let truth = &sample.truth;
        truth.cog[0] > nose
            && truth.pitch.abs() < LEVEL
            && truth.roll.abs() < LEVEL
            && !truth.toppled
    };
    samples
        .windows(LEVEL_SAMPLES)
        .position(|window| window.iter().all(level))
}

/// The samples from the first nose to the landing, or to the end.
fn climb(samples: &[Sample], landing: Option<usize>) -> &[Sample] {
    let end = landing.unwrap_or(samples.len());
    let start = samples
        .iter()
        .position(|sample| sample.truth.pitch > CLIMBING);
    start
        .and_then(|start| samples.get(start..end))
        .unwrap_or_default()
}

fn stopped(samples: &[Sample]) -> bool {
    let last = &samples[samples.len().saturating_sub(SAMPLE_HZ as usize)..];
    let path: f64 = last
        .iter()
        .map(|sample| sample.truth.ground_speed.abs())
        .sum();
    !last.is_empty() && path / (last.len() as f64) < STANDING_MPS
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

impl fmt::Display for Summary {
    /// The few lines that a terminal shows.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let outcome = match (self.toppled, self.landing_time_s) {
            (true, _) => "toppled".to_owned(),
            (false, Some(time)) => format!("landed at {time:.2} s"),
            (false, None) => "upright".to_owned(),
        };
        let margin = self
            .min_backward_margin_m
            .map_or("none".to_owned(), |margin| {
                format!("{:.0} mm", margin * 1e3)
            });
        let boards: Vec<String> = self
            .nodes
            .iter()
            .map(|node| format!("{} ({})", node.name, node.board))
            .collect();
        let rows = [
            ("outcome", outcome),
            (
                "simulated",
                format!(
                    "{:.1} s in {:.1} s, {:.1} x real time",
                    self.simulated_s, self.wall_s, self.realtime_factor
                ),
            ),
            ("nodes", boards.join(", ")),
            (
                "belt error",
                format!(
                    "p99 {:.2} mm, max {:.2} mm",
                    self.tension_error_m.p99 * 1e3,
                    self.tension_error_m.max * 1e3
                ),
            ),
            (
                "pitch",
                format!("{:.1} to {:.1} deg", self.pitch_deg.min, self.pitch_deg.max),
            ),
            ("least margin", format!("{margin} to the back")),
            (
                "guard",
                format!(
                    "{} interventions, {} scaled, {} refused",
                    self.guard.interventions, self.guard.scaled, self.guard.refused
                ),
            ),
            (
                "bus",
                format!(
                    "load {:.0} % mean, {:.0} % peak; {} frames, worst wait {:.2} ms",
                    self.bus.load_mean * 100.0,
                    self.bus.load_max * 100.0,
                    self.bus.frames,
                    self.bus.worst_latency_ms
                ),
            ),
            ("state hash", self.state_hash.clone()),
        ];
        writeln!(f, "{} (seed {})", self.scenario, self.seed)?;
        for (name, value) in rows {
            writeln!(f, "  {name:<13} {value}")?;
        }
        for fault in &self.faults {
            let node = fault
                .node
                .map(|node| format!(" on {node}"))
                .unwrap_or_default();
            let noticed = match (&fault.noticed_by, fault.after_ms) {
                (Some(by), Some(after)) => format!("noticed by {by} after {after:.0} ms"),
                _ => "not noticed".to_owned(),
            };
            writeln!(
                f,
                "  {:<13} {}{node} at {:.2} s, {noticed}",
                "fault", fault.what, fault.time_s
            )?;
        }
        for sentence in &self.unmet {
            writeln!(f, "  {:<13} {sentence}", "NOT AS ASKED")?;
        }
        write!(
            f,
            "  {:<13} {}",
            "expectation",
            if self.expectation_met {
                "met"
            } else {
                "NOT met"
            }
        )
    }
}
