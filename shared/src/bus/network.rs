//! Network management (NMT), SYNC, heartbeat and emergency frames (CiA 301).

use crate::can::Frame;

/// Number of SYNC periods between two torque feed-forward frames. Feed-forward torques change
/// slowly. The guard sends them in the last quarter of a SYNC period, in a tick that has little
/// other work. If every tick has a SYNC, the guard sends none.
pub const OFFSET_SYNCS: u32 = 4;

/// Function codes. The identifier of a frame is a function code plus the node id. NMT (0x000) and
/// SYNC (0x080) are used without a node id.
pub mod function {
    /// Network management commands, from the master to all nodes.
    pub const NMT: u16 = 0x000;
    /// SYNC. With a node id added: the emergency frame of that node.
    pub const SYNC_OR_EMERGENCY: u16 = 0x080;
    /// First to sixth transmit PDO, as seen from the node that sends it. CiA 301 predefines four.
    /// The others use identifiers that CiA 301 leaves free, for node ids up to 47.
    pub const TPDO: [u16; 6] = [0x180, 0x280, 0x380, 0x480, 0x680, 0x6b0];
    /// First to fourth receive PDO, as seen from the node that receives and follows it.
    pub const RPDO: [u16; 4] = [0x200, 0x300, 0x400, 0x500];
    /// Boot-up message and heartbeat.
    pub const HEARTBEAT: u16 = 0x700;
}

/// Network management command of the master to one node or to all nodes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum NmtCommand {
    /// To "operational": the node exchanges process data.
    Start = 1,
    /// To "stopped".
    Stop = 2,
    /// To "pre-operational": the node answers service data (SDO) only.
    EnterPreOperational = 128,
    /// Restarts the node.
    ResetNode = 129,
}

/// Network management state, with its code in a heartbeat.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum NmtState {
    /// Boot-up message: sent once, after power-up.
    BootUp = 0,
    /// Stopped.
    Stopped = 4,
    /// The node exchanges process data.
    Operational = 5,
    /// The node waits for the master's start command.
    PreOperational = 127,
}

impl NmtState {
    const ALL: [Self; 4] = [
        Self::BootUp,
        Self::Stopped,
        Self::Operational,
        Self::PreOperational,
    ];
}

/// Content of an emergency frame: its node and its error code.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Emergency {
    /// The node that sent it.
    pub node: u8,
    /// Error code of [`crate::faults`]; 0 means "all clear".
    pub code: u16,
}

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(id & Frame::MAX_ID, data).unwrap_or_default()
}

/// Creates a SYNC frame without counter.
pub fn sync() -> Frame {
    frame(function::SYNC_OR_EMERGENCY, &[])
}

/// Returns whether a frame is a SYNC.
pub fn is_sync(received: &Frame) -> bool {
    received.id() == function::SYNC_OR_EMERGENCY
}

/// Creates an NMT command to `node`, or to all nodes if `node` is 0.
pub fn nmt(command: NmtCommand, node: u8) -> Frame {
    frame(function::NMT, &[command as u8, node])
}

/// Returns the error register (object 0x1001) while the newest error has this code: the bit of any
/// error, and that of its kind.
pub fn error_register(code: u16) -> u8 {
    let kind = match code >> 8 {
        0x00 => return 0,
        0x20..=0x2f => 1, // current
        0x30..=0x3f => 2, // voltage
        0x40..=0x4f => 3, // temperature
        0x81 | 0x82 => 4, // communication
        0xff => 7,        // specific to the maker
        _ => 0,
    };
    1 | 1 << kind
}

/// Whether a drive remarks upon its bus with this code, and has no fault: a lost frame, error
/// passive, recovered from bus-off, a PDO that is too short.
pub fn is_remark(code: u16) -> bool {
    matches!(code, 0x8110 | 0x8120 | 0x8140 | 0x8210)
}

/// Creates an emergency frame.
pub fn emergency(emergency: Emergency) -> Frame {
    let code = emergency.code.to_le_bytes();
    let register = error_register(emergency.code);
    frame(
        function::SYNC_OR_EMERGENCY + u16::from(emergency.node),
        &[code[0], code[1], register, 0, 0, 0, 0, 0],
    )
}

/// Returns the emergency in a received frame; `None` for any other frame.
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

/// A bit for each function code with which a node sends: emergency, process data, SDO answer and
/// heartbeat.
const SENT_FUNCTIONS: u16 = 0b0110_1010_1010_1010;

/// Returns whether only `node` may send a frame with this identifier.
pub fn is_of(received: &Frame, node: u8) -> bool {
    let (id, code) = (received.id(), received.id() >> 7);
    id & 0x7f == u16::from(node) && 1 << code & SENT_FUNCTIONS != 0
}

/// Creates the heartbeat of `node` in `state`.
pub fn heartbeat(node: u8, state: NmtState) -> Frame {
    frame(function::HEARTBEAT + u16::from(node), &[state as u8])
}

/// Returns node and state of a received heartbeat or boot-up message; `None` for any other frame.
pub fn as_heartbeat(received: &Frame) -> Option<(u8, NmtState)> {
    let node = received.id().checked_sub(function::HEARTBEAT)?;
    let &[code] = received.data() else {
        return None;
    };
    let state = NmtState::ALL
        .into_iter()
        .find(|state| *state as u8 == code)?;
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
            Frame::new(0x85, &[0x30, 0x81, 0x11, 0, 0, 0, 0, 0]).unwrap()
        );
        assert_eq!(as_emergency(&emergency(lost)), Some(lost));
        assert_eq!(as_emergency(&sync()), None);
        assert_eq!(
            as_heartbeat(&Frame::new(0x704, &[5]).unwrap()),
            Some((4, NmtState::Operational))
        );
        assert_eq!(as_heartbeat(&Frame::new(0x700, &[5]).unwrap()), None);
    }

    /// CiA 301, the predefined connection set: emergency, four transmit PDOs, SDO answer and
    /// heartbeat; and the fifth PDO of the guard. A node receives the others.
    #[test]
    fn a_node_sends_with_eight_of_its_identifiers() {
        for node in [1_u8, 4, 127] {
            let sent = [0x080, 0x180, 0x280, 0x380, 0x480, 0x580, 0x680, 0x700];
            for id in 0..0x800 {
                let frame = Frame::new(id, &[]).unwrap();
                let own = sent.iter().any(|code| code + u16::from(node) == id);
                assert_eq!(is_of(&frame, node), own, "{id:#x} {node}");
            }
        }
    }

    #[test]
    fn a_sync_is_known_from_an_emergency_and_a_command() {
        assert!(is_sync(&sync()));
        let emergency = emergency(Emergency { node: 1, code: 0 });
        assert!(!is_sync(&emergency) && !is_sync(&nmt(NmtCommand::Start, 0)));
    }
}
