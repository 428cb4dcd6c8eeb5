//! Progress and results of a run.

use crate::simulator::facts::RunFacts;
use crate::simulator::record::{BusFrame, Sample};

/// Progress of a run.
pub struct Progress<'a> {
    /// Virtual time, s.
    pub time_s: f64,
    /// Forward speed that the guard passes on, m/s.
    pub speed: f64,
    /// State of the guard.
    pub state: &'a str,
}

/// Results of a run.
pub struct Outcome {
    /// Samples at [`crate::simulator::record::SAMPLE_HZ`].
    pub samples: Vec<Sample>,
    /// Every frame that the bus delivered, in order.
    pub frames: Vec<BusFrame>,
    /// Facts collected by the runner.
    pub facts: RunFacts,
    /// Log lines of the nodes, with time and node.
    pub log: Vec<String>,
    /// Virtual times at which the operator's script changed the command, including its start, s.
    pub commands_s: Vec<f64>,
    /// Number of clients that took part.
    pub clients: usize,
}
