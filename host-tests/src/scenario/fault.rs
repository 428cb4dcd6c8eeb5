//! The nodes, and what can befall them and the bus.

use serde::{Deserialize, Serialize};

/// The nodes of all robots; each has some of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NodeName {
    /// Axle of the left track.
    LeftTrack,
    /// Axle of the right track.
    RightTrack,
    /// Axle of the chassis joint.
    ChassisJoint,
    /// The driving screw.
    Screw,
    /// Hip of Hylos' front left leg.
    FrontLeftHip,
    /// Knee of Hylos' front left leg.
    FrontLeftKnee,
    /// Steering of Hylos' front left leg.
    FrontLeftSteering,
    /// Wheel of Hylos' front left leg.
    FrontLeftWheel,
    /// Hip of Hylos' front right leg.
    FrontRightHip,
    /// Knee of Hylos' front right leg.
    FrontRightKnee,
    /// Steering of Hylos' front right leg.
    FrontRightSteering,
    /// Wheel of Hylos' front right leg.
    FrontRightWheel,
    /// Hip of Hylos' rear left leg.
    RearLeftHip,
    /// Knee of Hylos' rear left leg.
    RearLeftKnee,
    /// Steering of Hylos' rear left leg.
    RearLeftSteering,
    /// Wheel of Hylos' rear left leg.
    RearLeftWheel,
    /// Hip of Hylos' rear right leg.
    RearRightHip,
    /// Knee of Hylos' rear right leg.
    RearRightKnee,
    /// Steering of Hylos' rear right leg.
    RearRightSteering,
    /// Wheel of Hylos' rear right leg.
    RearRightWheel,
    /// Steering shaft of its front arm.
    FrontSteering,
    /// Of RT-Mover's rear arm.
    RearSteering,
    /// Roll shaft of its front arm.
    FrontRoll,
    /// Of RT-Mover's rear arm.
    RearRoll,
    /// Pitch shaft under its seat.
    SeatPitch,
    /// The guard.
    Guard,
}

impl NodeName {
    /// B2P2's.
    pub const ALL: [Self; 5] = [
        Self::LeftTrack,
        Self::RightTrack,
        Self::ChassisJoint,
        Self::Screw,
        Self::Guard,
    ];

    /// As written in a scenario file.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::LeftTrack => "left_track",
            Self::RightTrack => "right_track",
            Self::ChassisJoint => "chassis_joint",
            Self::Screw => "screw",
            Self::FrontLeftHip => "front_left_hip",
            Self::FrontLeftKnee => "front_left_knee",
            Self::FrontLeftSteering => "front_left_steering",
            Self::FrontLeftWheel => "front_left_wheel",
            Self::FrontRightHip => "front_right_hip",
            Self::FrontRightKnee => "front_right_knee",
            Self::FrontRightSteering => "front_right_steering",
            Self::FrontRightWheel => "front_right_wheel",
            Self::RearLeftHip => "rear_left_hip",
            Self::RearLeftKnee => "rear_left_knee",
            Self::RearLeftSteering => "rear_left_steering",
            Self::RearLeftWheel => "rear_left_wheel",
            Self::RearRightHip => "rear_right_hip",
            Self::RearRightKnee => "rear_right_knee",
            Self::RearRightSteering => "rear_right_steering",
            Self::RearRightWheel => "rear_right_wheel",
            Self::FrontSteering => "front_steering",
            Self::RearSteering => "rear_steering",
            Self::FrontRoll => "front_roll",
            Self::RearRoll => "rear_roll",
            Self::SeatPitch => "seat_pitch",
            Self::Guard => "guard",
        }
    }
}

impl std::fmt::Display for NodeName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}

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
    /// The node neither sends nor hears, but runs on.
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
