//! Options of a run.

use crate::programs::{Board, Program};
use crate::robots::NodeName;
use crate::scenario::Fault;
use crate::simulator::record::Sample;
use crate::simulator::slcan::SlcanPort;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Condition on the samples of a run, in order.
pub type EndWhen = Box<dyn FnMut(&Sample) -> bool>;

/// Fault that begins at its time, chosen from the samples of a run, in order.
pub type Inject = Box<dyn FnMut(&Sample) -> Option<Fault>>;

/// Options of a run.
#[derive(Default)]
pub struct Options {
    /// Programs that replace those of single nodes, with the board that they are built for.
    pub exchanged: Vec<(NodeName, Board, Program)>,
    /// Maximum speed, in virtual seconds per second of wall-clock time. If absent: 1 with a port
    /// for clients, else as fast as possible.
    pub speed: Option<f64>,
    /// Virtual time from which the operator commands no motion, s: speed 0, chassis angle
    /// unchanged.
    pub let_go_s: Option<f64>,
    /// Virtual time from which the operator requests to disarm, s.
    pub disarm_s: Option<f64>,
    /// Whether the run ends half a second after the robot has toppled.
    pub end_when_toppled: bool,
    /// Ends the run when the armed robot has stood still for this time, s.
    pub end_when_still_s: Option<f64>,
    /// Ends the run after the first sample for which this holds.
    pub end_when: Option<EndWhen>,
    /// Adds faults to those of the scenario during the run.
    pub inject: Option<Inject>,
    /// Port through which CAN clients take part. The first step waits for the first client.
    pub slcan: Option<SlcanPort>,
    /// Maximum wall-clock time to wait for the first client; unlimited if absent.
    pub slcan_wait: Option<Duration>,
    /// Maximum wall-clock time for an answer of a node; a minute if absent.
    pub node_timeout: Option<Duration>,
    /// Folder with a file for the flash of each node, as an absolute path of at most
    /// [`MAX_PATH`](tautrack::link::MAX_PATH) - 32 bytes. If absent, the flash is blank, and ends
    /// with the run.
    pub flash: Option<String>,
    /// Whether nodes whose flash is blank stay blank, instead of getting the scenario's settings.
    pub blank: bool,
    /// Flag that ends the run once it is set.
    pub interrupt: Option<Arc<AtomicBool>>,
}
