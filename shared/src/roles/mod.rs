//! The nodes of a robot as values: the part of the bus, the objects and the control core of each
//! role. A node has no I/O: a program carries frames, readings and flash to it and back.
//!
//! * [`drive`]: the roles axle and screw
//! * [`guard`]: the role guard
//! * [`settings`]: the objects of the settings
//! * `dictionary`: the objects of each role, generated from its table

mod dictionary;
pub mod drive;
pub mod guard;
pub mod settings;

use crate::bus::node::{Configuration, Table};
use crate::settings::{Setting, Settings};

pub use dictionary::{axle, guard as guard_objects, screw};

/// What the settings tell the node about its network.
fn configuration(settings: &Settings) -> Configuration {
    let (node_id, guard_id) = (settings.id(Setting::NodeId), settings.id(Setting::GuardId));
    let timeout_us = settings.milliseconds(Setting::HeartbeatTimeout);
    Configuration {
        node_id,
        heartbeat_ms: settings.get(Setting::HeartbeatPeriod) as u16,
        guard: (guard_id != node_id).then_some((guard_id, timeout_us)),
        listens: None,
    }
}

/// Vendor, product code and revision in a dictionary (object 0x1018).
pub fn identity(table: &Table) -> [u32; 3] {
    [1, 2, 3].map(|sub| table.constant(0x1018, sub))
}
