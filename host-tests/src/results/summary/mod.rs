//! What came out of a run, in figures.
//!
//! `computation` makes them of the samples: `motion` how far the robot drove, `belt` how taut its
//! belt was, `channels` what only this robot has, `verdicts` what the guard did. `expectation`
//! compares them with what the scenario expects, `notes` explains them, `table` prints them.

mod belt;
mod channels;
mod computation;
mod expectation;
mod motion;
mod notes;
mod table;
mod verdicts;

pub use belt::{TensionError, percentile};
pub use channels::{ChannelFigures, Range, SETTLED_S};
pub use verdicts::GuardFigures;
pub(crate) use verdicts::intervenes;

use crate::results::zmp::Figures;
use crate::simulator::facts::{FaultFacts, NodeFacts};
use serde::Serialize;
use std::collections::BTreeMap;

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
    /// `|L + L2 + L3 - K|` by the plant's truth, from the first pitch above 8 degrees to the
    /// landing or the end; of B2P2 alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tension_error_m: Option<TensionError>,
    /// Distance over ground, forward and backward added, by the plant's truth, m.
    pub driven_m: f64,
    /// Pitch by the plant's truth, degrees.
    pub pitch_deg: Range,
    /// Least horizontal distance from the rearmost contact to the centre of gravity, by the plant's
    /// truth, m; absent for a robot whose margin is a channel of its own.
    pub min_backward_margin_m: Option<f64>,
    /// Least margin to any edge by the guard's estimate while it drives, m; absent when it had
    /// none.
    pub min_guard_margin_m: Option<f64>,
    /// How far the zero moment point went from the centre of gravity during the climb, as in Fig. 8
    /// of Paillat et al.; absent without one.
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
