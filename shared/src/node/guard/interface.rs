//! What goes into a tick of the guard, and what comes out.

use crate::bus::pdo::{
    GuardMargins, GuardMotion, GuardPassed, GuardPosition, GuardState, OperatorCommand,
};
use crate::can::Frame;
use crate::estimate::state::State as RobotState;
use crate::robots::MAX_DRIVES;
use crate::sensors::BodySensors;
use heapless::Vec;

/// Largest number of frames that one tick sends: SYNC, network management, and for each drive a
/// set-point or a request for its scale.
pub const MAX_SENT: usize = 2 * MAX_DRIVES + 2;

/// What the guard sensed and received since the tick before.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// Time since power-up, us.
    pub now_us: u64,
    /// Sensors on the body.
    pub body: Option<BodySensors>,
    /// Bytes of the GNSS receiver.
    pub serial: &'a [u8],
    /// The operator's newest command, if one came.
    pub operator: Option<OperatorCommand>,
    /// The emergency stop is actuated, whoever did it.
    pub emergency_stop: bool,
    /// Every frame that was received, in order.
    pub frames: &'a [Frame],
}

/// What the guard sends and tells.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Outputs {
    /// Frames to send in this order: SYNC, network management, set-points; or torques in advance.
    pub frames: Vec<Frame, MAX_SENT>,
    /// Payload of TPDO 1.
    pub motion: GuardMotion,
    /// Payload of TPDO 2.
    pub state: GuardState,
    /// Payload of TPDO 3.
    pub margins: GuardMargins,
    /// Payload of TPDO 4.
    pub passed: GuardPassed,
    /// The robot's state and payload of TPDO 5, once in a SYNC period.
    pub robot: Option<(RobotState, GuardPosition)>,
    /// Times that a command was refused (object 0x4005:1).
    pub refused: u32,
    /// Times that a command was scaled (object 0x4005:2).
    pub scaled: u32,
    /// Code of an emergency frame to send now; 0 is "all clear".
    pub emergency: Option<u16>,
    /// The drives that have a fault, a bit for each in the order of `Body::drive_ids` (object 0x4009);
    /// brought up to date once in a SYNC period and with every emergency frame.
    pub faulty_drives: u16,
}

/// A node's fault or loss that holds the robot.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct FaultReport {
    pub node: u8,
    pub code: u16,
}
