//! Faults of nodes, bus and sensor chips that a scenario can inject.

use crate::robots::node_name::NodeName;
use serde::{Deserialize, Serialize};
use tautrack::link::ChipFault;

/// A fault that the run injects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// Kind of the fault.
    pub what: FaultKind,
    /// Virtual time at which it begins.
    pub at_s: f64,
    /// Virtual time at which it ends; absent if it stays.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub until_s: Option<f64>,
    /// Time within which a node must report the fault on the bus.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub notice_within_ms: Option<f64>,
}

/// Kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FaultKind {
    /// The node loses its power: it sends nothing, and its motor is free.
    NodeDead(NodeName),
    /// The node's encoder keeps its last count.
    EncoderFrozen(NodeName),
    /// The node neither sends nor receives, but keeps running.
    BusCut(NodeName),
    /// The node loses its power at `at_s` and starts again at `until_s`, or at once without it: a
    /// new process with the same settings, whose clock begins at 0. Only the guard can restart.
    Restart(NodeName),
    /// Every frame on the bus is lost with this probability.
    FrameLoss {
        /// Probability, 0 to 1.
        probability: f64,
    },
    /// One data bit of one frame is inverted, and the CRC does not detect it.
    FrameFlip {
        /// Number of the frame, counted from `at_s`. If the frame is too short for the bit, the bit
        /// of the next frame is inverted.
        frame: u64,
        /// Bit of the frame's data, 0 to 63.
        bit: u8,
    },
    /// A sensor chip on the guard's board has a fault.
    Sensor {
        /// The chip.
        chip: SensorChip,
        /// Its fault.
        fault: ChipFault,
    },
}

/// Sensor chip on the guard's board, in the order of [`tautrack::link::BodyMeasurands::faults`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SensorChip {
    /// Inertial unit: accelerometer and gyroscope.
    InertialUnit,
    /// Magnetometer.
    Magnetometer,
    /// Inclinometer.
    Inclinometer,
}

impl FaultKind {
    /// The node that has the fault; `None` for a fault of the bus.
    pub fn node(&self) -> Option<NodeName> {
        match *self {
            Self::NodeDead(node)
            | Self::EncoderFrozen(node)
            | Self::BusCut(node)
            | Self::Restart(node) => Some(node),
            Self::Sensor { .. } => Some(NodeName::GUARD),
            Self::FrameLoss { .. } | Self::FrameFlip { .. } => None,
        }
    }

    /// Describes the fault in a few words for reports.
    pub fn words(&self) -> String {
        match *self {
            Self::NodeDead(_) => "node dead".into(),
            Self::EncoderFrozen(_) => "encoder frozen".into(),
            Self::BusCut(_) => "bus cut".into(),
            Self::Restart(_) => "restart".into(),
            Self::FrameLoss { probability } => format!("{} % of frames lost", probability * 100.0),
            Self::FrameFlip { frame, bit } => format!("bit {bit} of frame {frame} flipped"),
            Self::Sensor { chip, fault } => {
                let chip = match chip {
                    SensorChip::InertialUnit => "inertial unit",
                    SensorChip::Magnetometer => "magnetometer",
                    SensorChip::Inclinometer => "inclinometer",
                };
                let fault = match fault {
                    ChipFault::BusStuck => "holds its bus",
                    ChipFault::NoAcknowledge => "does not acknowledge",
                    ChipFault::Frozen => "frozen",
                    ChipFault::WrongIdentity => "has a wrong identity",
                    ChipFault::HalfRate => "at half its rate",
                    ChipFault::Noise => "noisy",
                };
                format!("{chip} {fault}")
            }
        }
    }
}
