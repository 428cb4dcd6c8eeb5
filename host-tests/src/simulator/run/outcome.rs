//! Results of a run.

use super::RunError;
use crate::simulator::facts::RunFacts;
use crate::simulator::record::Sample;

/// Results of a run whose samples are kept in memory.
pub struct Outcome {
    /// Samples at [`crate::simulator::record::SAMPLE_HZ`].
    pub samples: Vec<Sample>,
    /// Facts collected by the runner.
    pub facts: RunFacts,
    /// Virtual times at which the operator's script changed the command, including its start, s.
    pub commands_s: Vec<f64>,
}

/// End of a run, whose record went into a [`super::Sink`].
pub struct Ending {
    /// Facts collected by the runner.
    pub facts: RunFacts,
    /// Virtual times at which the operator's script changed the command, including its start, s.
    pub commands_s: Vec<f64>,
    /// Number of clients that took part.
    pub clients: usize,
    /// Why the run ended early; absent if it did not.
    pub error: Option<RunError>,
}
