//! What a run tells on its way and leaves behind.

use crate::simulator::facts::RunFacts;
use crate::simulator::record::{BusFrame, Sample};

/// How far a run has come.
pub struct Progress<'a> {
    /// Virtual time, s.
    pub time_s: f64,
    /// Forward speed that the guard passes on, m/s.
    pub speed: f64,
    /// State of the guard.
    pub state: &'a str,
}

/// What a run leaves behind.
pub struct Outcome {
    /// Samples at [`crate::simulator::record::SAMPLE_HZ`].
    pub samples: Vec<Sample>,
    /// Every frame that the bus delivered, in order.
    pub frames: Vec<BusFrame>,
    /// What only the runner knows.
    pub facts: RunFacts,
    /// Log lines of the nodes, with time and node.
    pub log: Vec<String>,
    /// Virtual times at which the operator's script changed what is commanded, its start included,
    /// s.
    pub commands_s: Vec<f64>,
    /// Number of clients that took part.
    pub clients: usize,
}
