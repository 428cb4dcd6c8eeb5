//! Facts about a run that its samples do not contain.

use crate::robots::NodeName;
use serde::Serialize;

/// Facts about a run, collected by the runner.
#[derive(Clone, Debug, Default)]
pub struct RunFacts {
    /// Wall-clock time from the first step to the last, s.
    pub wall_s: f64,
    /// Number of lockstep steps.
    pub steps: u64,
    /// The nodes, in the order in which they were started.
    pub nodes: Vec<NodeFacts>,
    /// Number of frames that the bus delivered.
    pub frames: u64,
    /// Maximum time that a frame waited for the bus, ms.
    pub worst_latency_ms: f64,
    /// The scenario's faults in its order, each with its consequence.
    pub faults: Vec<FaultFacts>,
    /// Hash of all bits of the ground truth and all delivered frames of every step, hexadecimal.
    pub state_hash: String,
}

/// Facts about one node of a run.
#[derive(Clone, Debug, Serialize)]
pub struct NodeFacts {
    /// Name of the node in the robot.
    pub name: NodeName,
    /// Role of the node: `axle`, `screw` or `guard`.
    pub role: String,
    /// Board of the node: `mps2`, `host`, or that of a flash image.
    pub board: String,
    /// `CANopen` node id.
    pub node_id: u8,
    /// SHA-256 of the program file, hexadecimal.
    pub program_sha256: String,
}

/// Facts about one fault of a scenario.
#[derive(Clone, Debug, Serialize)]
pub struct FaultFacts {
    /// Virtual time at which the fault began, s.
    pub time_s: f64,
    /// Node with the fault; `None` for a fault of the bus.
    pub node: Option<NodeName>,
    /// Short description of the fault.
    pub what: String,
    /// Node that reported the fault first on the bus; absent if none did.
    pub noticed_by: Option<String>,
    /// Time from the fault to this report, ms.
    pub after_ms: Option<f64>,
}
