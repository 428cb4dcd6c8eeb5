//! What only the runner knows of a run.

use crate::robots::NodeName;
use serde::Serialize;

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
