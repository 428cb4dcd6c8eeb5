//! What can befall the nodes and the bus.

use crate::robots::node_name::NodeName;
use serde::{Deserialize, Serialize};

/// Something that goes wrong.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// What.
    pub what: FaultKind,
    /// Virtual time from which.
    pub at_s: f64,
    /// Virtual time until which; for good when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub until_s: Option<f64>,
    /// The guard, or the node itself, must say so on the bus within this time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub notice_within_ms: Option<f64>,
}

/// Kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FaultKind {
    /// The node's power is gone: it sends nothing, and its motor is free.
    NodeDead(NodeName),
    /// The node's encoder keeps its last count.
    EncoderFrozen(NodeName),
    /// The node neither sends nor receives, but runs on.
    BusCut(NodeName),
    /// The node loses its power at `at_s` and starts again at `until_s`, or at once: a new process
    /// with the same settings, whose clock begins at 0. The guard alone.
    Restart(NodeName),
    /// Every frame on the bus is lost with this probability.
    FrameLoss {
        /// 0 to 1.
        probability: f64,
    },
    /// One data bit of one frame arrives flipped and unnoticed by the CRC.
    FrameFlip {
        /// Number of the frame, counted from `at_s`; a frame too short for the bit passes the flip on to the next.
        frame: u64,
        /// Bit of its data, 0 to 63.
        bit: u8,
    },
}

impl FaultKind {
    /// The node that it befalls, if it is one.
    pub fn node(&self) -> Option<NodeName> {
        match *self {
            Self::NodeDead(node)
            | Self::EncoderFrozen(node)
            | Self::BusCut(node)
            | Self::Restart(node) => Some(node),
            Self::FrameLoss { .. } | Self::FrameFlip { .. } => None,
        }
    }

    /// A few words for reports.
    pub fn words(&self) -> String {
        match *self {
            Self::NodeDead(_) => "node dead".into(),
            Self::EncoderFrozen(_) => "encoder frozen".into(),
            Self::BusCut(_) => "bus cut".into(),
            Self::Restart(_) => "restart".into(),
            Self::FrameLoss { probability } => format!("{} % of frames lost", probability * 100.0),
            Self::FrameFlip { frame, bit } => format!("bit {bit} of frame {frame} flipped"),
        }
    }
}
