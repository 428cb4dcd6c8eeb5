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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FaultKind {
    /// The node loses its power: it sends nothing, and its motor is free.
    NodeDead(NodeName),
    /// The node's encoder keeps its last count.
    EncoderFrozen(NodeName),
    /// The node neither sends nor receives, but keeps running.
    BusCut(NodeName),
    /// A switch of the node does not change any more.
    SwitchStuck {
        /// The node.
        node: NodeName,
        /// The switch.
        switch: Switch,
        /// It reads as actuated, or else as not actuated.
        closed: bool,
    },
    /// The node loses its power at `at_s` and starts again at `until_s`, or in the next step
    /// without it: a new process with the same settings, whose clock begins at 0 and whose rotor is
    /// at rest.
    Restart(NodeName),
    /// Every frame on the bus is lost with this probability.
    FrameLoss {
        /// Probability, 0 to 1.
        probability: f64,
    },
    /// One data bit of one frame is inverted, and the CRC does not detect it.
    FrameFlip {
        /// Identifier of the frames that count; all count without it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        id: Option<u16>,
        /// Number of the frame, counted from `at_s`. If the frame is too short for the bit, the bit
        /// of the next frame is inverted.
        frame: u64,
        /// Bit of the frame's data, 0 to 63.
        bit: u8,
    },
    /// A participant that is no node sends a frame again and again, from `at_s` to `until_s`.
    Forger {
        /// Identifier of the frame.
        id: u16,
        /// Data of the frame, at most eight bytes.
        data: Vec<u8>,
        /// Period, ms.
        period_ms: u64,
    },
    /// The operator sends nothing.
    OperatorLost,
    /// The belt of this track comes off its sprocket: the motor turns without load, and the belt
    /// moves against the friction of its pulleys.
    BeltOff(NodeName),
    /// The ground under the belt of this track is slippery.
    SlipperyTrack {
        /// Node of the track.
        track: NodeName,
        /// Coefficient of friction, if the ground's is not below it.
        friction: f64,
    },
    /// A sensor chip on the guard's board has a fault.
    Sensor {
        /// The chip.
        chip: SensorChip,
        /// Its fault.
        fault: ChipFault,
    },
}

/// Switch of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Switch {
    /// Home switch.
    Home,
    /// Limit switch at the positive end of travel.
    PositiveLimit,
    /// Limit switch at the negative end of travel.
    NegativeLimit,
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
            | Self::SwitchStuck { node, .. }
            | Self::Restart(node)
            | Self::BeltOff(node)
            | Self::SlipperyTrack { track: node, .. } => Some(node),
            Self::Sensor { .. } => Some(NodeName::GUARD),
            Self::FrameLoss { .. }
            | Self::FrameFlip { .. }
            | Self::Forger { .. }
            | Self::OperatorLost => None,
        }
    }

    /// Describes the fault in a few words for reports.
    pub fn words(&self) -> String {
        match *self {
            Self::NodeDead(_) => "node dead".into(),
            Self::EncoderFrozen(_) => "encoder frozen".into(),
            Self::BusCut(_) => "bus cut".into(),
            Self::SwitchStuck { switch, closed, .. } => {
                let switch = match switch {
                    Switch::Home => "home",
                    Switch::PositiveLimit => "positive limit",
                    Switch::NegativeLimit => "negative limit",
                };
                let state = if closed { "closed" } else { "open" };
                format!("{switch} switch stuck {state}")
            }
            Self::Restart(_) => "restart".into(),
            Self::FrameLoss { probability } => format!("{} % of frames lost", probability * 100.0),
            Self::FrameFlip { id, frame, bit } => {
                let of = id.map_or_else(String::new, |id| format!(" with identifier {id:#05x}"));
                format!("bit {bit} of frame {frame}{of} flipped")
            }
            Self::Forger { id, .. } => format!("forged frames {id:#05x}"),
            Self::OperatorLost => "operator lost".into(),
            Self::BeltOff(_) => "belt off".into(),
            Self::SlipperyTrack { friction, .. } => format!("slips at a friction of {friction}"),
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
