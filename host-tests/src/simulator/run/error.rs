//! Errors of a run.

use super::Unwritten;
use super::node::NodeError;
use crate::simulator::bus::Overflow;
use std::fmt;

/// Reason why a run ended before its planned end.
#[derive(Debug)]
pub enum RunError {
    /// A node could not be started, refused its settings, or did not answer.
    Node(NodeError),
    /// A node or the operator sends more than the bus can carry.
    Overflow(Overflow),
    /// The user ended the run.
    Interrupted,
    /// The scenario's operator is a client, and no client opened the channel in time.
    NoClient,
    /// A file of the results cannot be written.
    Unwritten(Unwritten),
}

impl fmt::Display for RunError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Node(error) => write!(f, "{error}"),
            Self::Overflow(error) => write!(f, "the bus is overloaded: {error}"),
            Self::Unwritten(error) => write!(f, "{error}"),
            Self::Interrupted => write!(f, "interrupted by the user"),
            Self::NoClient => write!(
                f,
                "no client opened the channel, and a client is the operator"
            ),
        }
    }
}

impl std::error::Error for RunError {}

impl From<NodeError> for RunError {
    fn from(error: NodeError) -> Self {
        Self::Node(error)
    }
}

impl From<Overflow> for RunError {
    fn from(error: Overflow) -> Self {
        Self::Overflow(error)
    }
}

impl From<Unwritten> for RunError {
    fn from(error: Unwritten) -> Self {
        Self::Unwritten(error)
    }
}
