//! Configuration of a node's bus: its object dictionary, the robot's identifiers and its guard.

use tautrack::bus::heartbeat::Monitor;
use zencan_node::common::AtomicCell;
use zencan_node::common::nmt::NmtState;
use zencan_node::object_dict::ODEntry;
use zencan_node::pdo::Pdo;

/// The statics that are generated from a role's dictionary.
#[derive(Clone, Copy)]
pub struct Dictionary {
    /// State of NMT (network management).
    pub state: &'static AtomicCell<NmtState>,
    /// Receive PDOs.
    pub receive_pdos: &'static [Pdo<'static>],
    /// Transmit PDOs.
    pub transmit_pdos: &'static [Pdo<'static>],
    /// The objects of the dictionary.
    pub table: &'static [ODEntry<'static>],
    /// Sets the serial number in the identity (object 0x1018).
    pub set_serial_number: fn(u32),
}

/// COB-ID that a receive PDO has in this robot, with the PDO's communication parameter.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Listen {
    /// Index of the communication parameter, from 0x1400.
    pub parameter: u16,
    /// Identifier to receive.
    pub id: u16,
}

/// Guard that this node follows, identified on the bus.
#[derive(Clone, Copy, Debug)]
pub struct Master {
    /// Node id of the guard.
    pub node_id: u8,
    /// Monitor of the guard's heartbeat.
    pub heartbeat: Monitor,
    /// The newest heartbeat says that the guard no longer waits for its drives.
    pub ready: bool,
}
