//! What a node is told of its dictionary, its robot's identifiers and its guard.

use tautrack::bus::heartbeat::Monitor;
use zencan_node::object_dict::ODEntry;
use zencan_node::{NodeMbox, NodeState};

/// The statics that are generated from a role's dictionary.
#[derive(Clone, Copy)]
pub struct Dictionary {
    /// Frames in and out of the stack.
    pub mailbox: &'static NodeMbox,
    /// State of NMT and PDOs.
    pub state: &'static NodeState<'static>,
    /// The objects.
    pub table: &'static [ODEntry<'static>],
}

/// COB-ID that a receive PDO has in this robot: its communication parameter and the identifier.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Listen {
    /// Index of the communication parameter, from 0x1400.
    pub parameter: u16,
    /// The identifier to receive.
    pub id: u16,
}

/// The guard that this node follows, as the bus sees it.
#[derive(Clone, Copy, Debug)]
pub struct Master {
    /// Its node id.
    pub node_id: u8,
    /// Its heartbeat.
    pub heartbeat: Monitor,
}
