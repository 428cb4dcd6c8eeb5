//! The figures of a run, as written to `summary.json` and printed on the terminal.
//!
//! `computation` computes them sample by sample. `motion` computes how far the robot drove, `belt`
//! the belt's strain, `percentile` its percentiles, `channels` the figures of robot-specific
//! channels, `verdicts` counts the guard's interventions. `expectation` compares the figures with
//! the scenario's expectation, `notes` explains them, `table` prints them.

mod belt;
mod channels;
mod computation;
mod expectation;
mod hold;
mod motion;
mod notes;
mod percentile;
mod table;
mod verdicts;

pub use belt::TensionError;
pub use channels::{ChannelFigures, Range, SETTLED_S};
pub use computation::Statistics;
pub use percentile::Largest;
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
    /// Whether the run met everything that the scenario expects.
    pub expectation_met: bool,
    /// The expectations that were not met, one sentence each.
    pub unmet: Vec<String>,
    /// Why the run ended early; absent if it did not.
    pub ended_early: Option<String>,
    /// Number of CAN clients that took part.
    pub clients: usize,
    /// Whether the guard armed the robot.
    pub armed: bool,
    /// Whether the robot landed: it stood level behind the last nose.
    pub landed: bool,
    /// Whether the robot turned over.
    pub toppled: bool,
    /// Virtual time of the landing, s.
    pub landing_time_s: Option<f64>,
    /// Whether the robot stood still during the last second.
    pub stopped: bool,
    /// Virtual time of the run, s.
    pub simulated_s: f64,
    /// Wall-clock time of the run, s.
    pub wall_s: f64,
    /// Ratio of virtual to wall-clock time.
    pub realtime_factor: f64,
    /// Number of lockstep steps.
    pub steps: u64,
    /// Strain or slack of the belt `|L + L2 + L3 - K|` in the simulator's ground truth, from the
    /// first pitch above 8 degrees to the landing or the end, m; only of a robot with a belt.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tension_error_m: Option<TensionError>,
    /// Distance driven over ground in the simulator's ground truth, forward and backward added, m.
    pub driven_m: f64,
    /// Pitch in the simulator's ground truth, degrees.
    pub pitch_deg: Range,
    /// Minimum horizontal distance from the rearmost contact to the centre of gravity in the
    /// simulator's ground truth, m; absent for a robot whose margin is one of its channels.
    pub min_backward_margin_m: Option<f64>,
    /// Minimum margin to any edge in the guard's estimate while it is armed, m; absent if it had no
    /// estimate.
    pub min_guard_margin_m: Option<f64>,
    /// Difference of zero moment point and centre of gravity during the climb, as in Fig. 8 of
    /// Paillat et al.; absent without a climb, and for a robot without this
    /// computation.
    pub zero_moment_point: Option<Figures>,
    /// Figures of the robot-specific channels by name; the last word of a name is the unit.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub channels: BTreeMap<&'static str, ChannelFigures>,
    /// Names of the channels that the terminal shows.
    #[serde(skip)]
    pub headlines: &'static [&'static str],
    /// How often the guard intervened.
    pub guard: GuardFigures,
    /// Sentences about figures that need an explanation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Load and latency of the bus.
    pub bus: BusFigures,
    /// The faults that the scenario injected, with what became of them.
    pub faults: Vec<FaultFacts>,
    /// The nodes and their programs.
    pub nodes: Vec<NodeFacts>,
    /// Hash over all bits of the ground truth and all delivered frames of every step, hexadecimal.
    pub state_hash: String,
}

/// Load and latency of the bus.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct BusFigures {
    /// Maximum load over 100 ms, 0 to 1.
    pub load_max: f64,
    /// Mean load, 0 to 1.
    pub load_mean: f64,
    /// Number of frames delivered.
    pub frames: u64,
    /// Maximum time that a frame waited for the bus, ms.
    pub worst_latency_ms: f64,
}
