//! How a scenario is run.

use crate::programs::{Board, Program};
use crate::robots::NodeName;
use crate::simulator::slcan::SlcanPort;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// How a scenario is run.
#[derive(Default)]
pub struct Options {
    /// Programs that take the place of a node's own, with the board that they are built for.
    pub exchanged: Vec<(NodeName, Board, Program)>,
    /// Maximum of virtual seconds per second of the wall clock. If absent, 1 with a port for
    /// clients, and as fast as possible without.
    pub speed: Option<f64>,
    /// Virtual time at which the operator lets go: no speed asked any more, the chassis left as it
    /// is, s.
    pub let_go_s: Option<f64>,
    /// Virtual time from which the operator requests to disarm, s.
    pub disarm_s: Option<f64>,
    /// Ends the run half a second after the robot turned over.
    pub end_when_toppled: bool,
    /// Ends the run once the armed robot has stood still for so long, s.
    pub end_when_still_s: Option<f64>,
    /// A port through which CAN clients take part. The first step waits for the first client.
    pub slcan: Option<SlcanPort>,
    /// Maximum time of the wall clock to wait for the first client; without limit if absent.
    pub slcan_wait: Option<Duration>,
    /// Maximum time of the wall clock that a node may take for an answer; a minute if absent.
    pub node_timeout: Option<Duration>,
    /// Ends the run once it is set.
    pub interrupt: Option<Arc<AtomicBool>>,
}
