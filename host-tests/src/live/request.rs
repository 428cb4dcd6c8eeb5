//! Requests of the page, as JSON: `{"advance": 16}`.

use super::Command;
use crate::scenario::{FaultKind, OperatorRequest};
use serde::Deserialize;
use serde_json::Value;

/// A request of the page.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum Request {
    /// Starts a run; the one before ends.
    Start {
        /// Text of a scenario file.
        scenario: String,
        /// Changes to the scenario, as a merge patch (RFC 7396).
        #[serde(default)]
        changes: Value,
        /// Whether a person is the operator, instead of the scenario's.
        person: bool,
    },
    /// Runs this number of steps, or until the scenario ends. Answers with the sample of the last.
    Advance(u64),
    /// Commands this from the operator's next command on.
    Command(Command),
    /// Requests this from the operator's next command on.
    Ask(OperatorRequest),
    /// Lets a fault begin.
    Break(FaultKind),
    /// Lets a fault end.
    Mend(FaultKind),
    /// Sends a frame from a client.
    Send {
        /// Identifier.
        id: u16,
        /// Data.
        data: Vec<u8>,
    },
    /// Whether the delivered frames are kept for the next answer to `bus`.
    Listen(bool),
    /// Runs this number of steps, or until the scenario ends. Answers with the delivered frames
    /// alone.
    Bus(u64),
    /// Answers with the ground: minimum and maximum of x, then of y, and the size of a cell, m.
    Ground {
        /// Minimum and maximum of x, then of y, m.
        area: [[f64; 2]; 2],
        /// Maximum distance of two lines of points, m.
        cell: f64,
    },
    /// Answers with the run's scenario and its hash.
    Save,
}
