//! Inputs and outputs of the guard's tick.

use crate::bus::pdo::{
    GuardClearance, GuardMargins, GuardMotion, GuardPassed, GuardPosition, GuardState,
    OperatorCommand,
};
use crate::can::Frame;
use crate::estimate::state::State as RobotState;
use crate::robots::MAX_DRIVES;
use crate::sensors::BodySensors;
use heapless::Vec;

/// Maximum number of frames that one tick sends: SYNC, network management, and for each drive a
/// set-point and a request for its scale.
pub const MAX_SENT: usize = 2 * MAX_DRIVES + 2;

/// Readings and messages since the previous tick.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// Time since power-up, us.
    pub now_us: u64,
    /// Readings of the sensors on the robot's body, if there are any.
    pub body: Option<BodySensors>,
    /// Bytes from the GNSS receiver.
    pub serial: &'a [u8],
    /// The operator's newest command, if one came.
    pub operator: Option<OperatorCommand>,
    /// The emergency stop is actuated, by whatever source.
    pub emergency_stop: bool,
    /// All frames that were received, in order.
    pub frames: &'a [Frame],
}

/// Outputs of the guard's tick.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Outputs {
    /// Frames to send, in this order: SYNC, network management, requests for scales, set-points; or
    /// else the torque feed-forward.
    pub frames: Vec<Frame, MAX_SENT>,
    /// Payload of TPDO 1.
    pub motion: GuardMotion,
    /// Payload of TPDO 2.
    pub state: GuardState,
    /// Payload of TPDO 3.
    pub margins: GuardMargins,
    /// Payload of TPDO 4.
    pub passed: GuardPassed,
    /// Payload of TPDO 6.
    pub clearance: GuardClearance,
    /// Passed and measured slack of the belts, um (objects 0x4004:5 and 0x4004:6).
    pub slack: [i32; 2],
    /// Estimated tension of the belts, 0.1 N (object 0x4004:7).
    pub belt_tension: i16,
    /// The robot's state and payload of TPDO 5, once in a SYNC period.
    pub robot: Option<(RobotState, GuardPosition)>,
    /// Number of refused commands (object 0x4005:1).
    pub refused: u32,
    /// Number of scaled commands (object 0x4005:2).
    pub scaled: u32,
    /// Code of an emergency frame to send now; 0 is "all clear".
    pub emergency: Option<u16>,
    /// The drives that have a fault, one bit for each in the order of `Body::drive_ids` (object
    /// 0x4009). Updated once in a SYNC period and with every emergency frame.
    pub faulty_drives: u16,
}

/// Fault or loss of a node, which holds the robot.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct FaultReport {
    pub node: u8,
    pub code: u16,
}
