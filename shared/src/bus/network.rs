//! Network management, SYNC, heartbeat and emergency frames (`CiA` 301).

use crate::can::Frame;

/// SYNCs from one torque in advance to the next: such torques change slowly. They are sent in the last quarter of a period, in a
/// tick that has little else to do; with SYNC in every tick there is none.
pub const OFFSET_SYNCS: u32 = 4;

/// Function codes: the identifier of a frame is one of these plus the node id, 0x000 and 0x080 alone without.
pub mod function {
    /// Network management commands, from the master to all.
    pub const NMT: u16 = 0x000;
    /// SYNC alone; with a node id behind it: that node's emergency frame.
    pub const SYNC_OR_EMERGENCY: u16 = 0x080;
    /// First to fifth transmit PDO, as the node that sends it sees it. `CiA` 301 predefines four; the fifth has identifiers that
    /// it leaves free, for nodes up to 95.
    pub const TPDO: [u16; 5] = [0x180, 0x280, 0x380, 0x480, 0x680];
    /// First to fourth receive PDO, as the node that obeys it sees it.
    pub const RPDO: [u16; 4] = [0x200, 0x300, 0x400, 0x500];
    /// Boot-up and heartbeat.
    pub const HEARTBEAT: u16 = 0x700;
}

/// Command of the network's master to one node or to all.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum NmtCommand {
    /// To operational: process data flows.
    Start = 1,
    /// To stopped.
    Stop = 2,
    /// To pre-operational: only service data.
    EnterPreOperational = 128,
    /// Restarts the node.
    ResetNode = 129,
}

/// State in a heartbeat.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum NmtState {
    /// The one frame after power-up.
    BootUp,
    /// Stopped.
    Stopped,
    /// Process data flows.
    Operational,
    /// Waiting for the master.
    PreOperational,
}

/// An emergency frame's content that this project uses: error code and error register.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Emergency {
    /// The node that sent it.
    pub node: u8,
    /// Error code of [`crate::faults`]; 0 is "all clear".
    pub code: u16,
}

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(id & Frame::MAX_ID, data).unwrap_or_default()
}

/// SYNC frame without counter.
pub fn sync() -> Frame {
    frame(function::SYNC_OR_EMERGENCY, &[])
}

/// True for [`sync`].
pub fn is_sync(received: &Frame) -> bool {
    received.id() == function::SYNC_OR_EMERGENCY
}

/// NMT command to `node`, or to all for 0.
pub fn nmt(command: NmtCommand, node: u8) -> Frame {
    frame(function::NMT, &[command as u8, node])
}

/// Emergency frame of `node`; the error register's generic bit is set unless the code is "all clear".
pub fn emergency(emergency: Emergency) -> Frame {
    let code = emergency.code.to_le_bytes();
    let register = u8::from(emergency.code != 0);
    frame(
        function::SYNC_OR_EMERGENCY + u16::from(emergency.node),
        &[code[0], code[1], register, 0, 0, 0, 0, 0],
    )
}

/// The emergency in a received frame, if it is one.
pub fn as_emergency(received: &Frame) -> Option<Emergency> {
    let node = received.id().checked_sub(function::SYNC_OR_EMERGENCY)?;
    match (node, received.data()) {
        (1..=127, [low, high, ..]) => Some(Emergency {
            node: node as u8,
            code: u16::from_le_bytes([*low, *high]),
        }),
        _ => None,
    }
}

/// Node and state of a received heartbeat or boot-up frame, if it is one.
pub fn as_heartbeat(received: &Frame) -> Option<(u8, NmtState)> {
    let node = received.id().checked_sub(function::HEARTBEAT)?;
    let state = match received.data() {
        [0] => NmtState::BootUp,
        [4] => NmtState::Stopped,
        [5] => NmtState::Operational,
        [127] => NmtState::PreOperational,
        _ => return None,
    };
    (1..=127).contains(&node).then_some((node as u8, state))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_those_of_the_standard() {
        assert_eq!(sync(), Frame::new(0x80, &[]).unwrap());
        assert_eq!(nmt(NmtCommand::Start, 3), Frame::new(0, &[1, 3]).unwrap());
        let lost = Emergency {
            node: 5,
            code: 0x8130,
        };
        assert_eq!(
            emergency(lost),
            Frame::new(0x85, &[0x30, 0x81, 1, 0, 0, 0, 0, 0]).unwrap()
        );
        assert_eq!(as_emergency(&emergency(lost)), Some(lost));
        assert_eq!(as_emergency(&sync()), None);
        assert_eq!(
            as_heartbeat(&Frame::new(0x704, &[5]).unwrap()),
            Some((4, NmtState::Operational))
        );
        assert_eq!(as_heartbeat(&Frame::new(0x700, &[5]).unwrap()), None);
    }
}
