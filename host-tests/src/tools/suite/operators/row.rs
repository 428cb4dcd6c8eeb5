//! Result of one run of the operators' suite.

use serde::{Deserialize, Serialize};

/// Where and how a robot turned over.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Topple {
    /// Virtual time, s.
    pub time_s: f64,
    /// Whether it fell over an edge that is not fair ground.
    pub over_edge: bool,
    /// Pitch, roll and chassis angle one second before, degrees.
    pub attitude_deg: [f64; 3],
    /// Speed, m/s, and chassis angle, degrees, commanded one second before.
    pub commanded: [f64; 2],
    /// The guard's verdict one second before.
    pub verdict: String,
}

/// Number of commands by what the guard did with them until the next command, counted while the
/// robot was armed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Commands {
    /// Passed unchanged.
    pub passed: u64,
    /// Scaled at some time, and never refused.
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
    /// Number of earlier draws, which toppled before the operator commanded anything.
    pub drawn_again: u64,
    /// SHA-256 of the scenario file.
    pub scenario: String,
    /// SHA-256 of the programs.
    pub programs: String,
    /// Ground and load, in words.
    pub about: String,
    /// How the robot turned over; absent if it did not.
    pub topple: Option<Topple>,
    /// Whether the robot was armed at some time.
    pub armed: bool,
    /// Fraction of the time since it was first armed for which it was armed, 0 to 1.
    pub armed_share: f64,
    /// Distance driven until the robot toppled, forward and backward added, m.
    pub distance_m: f64,
    /// Commands by what the guard did with them.
    pub commands: Commands,
    /// Virtual time, including that of earlier draws, s.
    pub simulated_s: f64,
}

impl Row {
    /// Whether the robot turned over on fair ground.
    pub fn failed(&self) -> bool {
        self.topple.as_ref().is_some_and(|topple| !topple.over_edge)
    }
}
