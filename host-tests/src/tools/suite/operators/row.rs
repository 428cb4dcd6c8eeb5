//! Result of one run.

use serde::{Deserialize, Serialize};

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
