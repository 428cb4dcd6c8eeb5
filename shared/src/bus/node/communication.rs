//! Objects of communication (0x1003 to 0x1029, CiA 301) that are no parameters of process data:
//! error history, SYNC, emergency, heartbeats, and the behaviour on errors.

use super::Configuration;
use super::dictionary::{Abort, Address, Value, number};
use crate::bus::heartbeat::Monitor;
use crate::bus::network::function;
use heapless::Deque;

/// Maximum number of errors in the history.
const ERRORS: usize = 8;
/// Bit of the identifier of SYNC: the node sends it.
const SENDS_SYNC: u32 = 1 << 30;
/// Behaviour on an error of communication (0x1029): the network state does not change. The control
/// core reacts to what is missing.
const NO_CHANGE: u32 = 1;

/// Values of the objects.
#[derive(Clone, Debug)]
pub(super) struct Communication {
    configuration: Configuration,
    /// Period of the heartbeat, ms; 0 for none.
    pub heartbeat_ms: u16,
    /// Entry of a client in the consumer heartbeat time (0x1016:2): node id and time, ms.
    client: u32,
    monitor: Monitor,
    /// Codes of errors, the newest first.
    errors: Deque<u16, ERRORS>,
}

impl Communication {
    pub fn new(configuration: Configuration) -> Self {
        Self {
            configuration,
            heartbeat_ms: 0,
            client: 0,
            monitor: Monitor::new(0),
            errors: Deque::new(),
        }
    }

    /// Restores the values at start, but not the history.
    pub fn restore(&mut self) {
        self.heartbeat_ms = self.configuration.heartbeat_ms;
        self.client = 0;
    }

    /// Adds an error to the history.
    pub fn note_error(&mut self, code: u16) {
        if self.errors.is_full() {
            self.errors.pop_back();
        }
        // Cannot fail: there is room.
        let _ = self.errors.push_front(code);
    }

    /// Takes note of a heartbeat of another node.
    pub fn note_heartbeat(&mut self, node: u8, now_us: u64) {
        if self.watched().is_some_and(|watched| watched == node) {
            self.monitor.received(now_us);
        }
    }

    /// Returns whether the client whose heartbeat the node watches has fallen silent since the last
    /// call.
    pub fn loses_client(&mut self, now_us: u64) -> bool {
        let lost = self.watched().is_some() && self.monitor.lost(now_us);
        if lost {
            self.watch();
        }
        lost
    }

    fn watched(&self) -> Option<u8> {
        let (node, time) = ((self.client >> 16) as u8, self.client as u16);
        (node != 0 && time != 0).then_some(node)
    }

    fn watch(&mut self) {
        let time_us = u64::from(self.client as u16) * 1_000;
        self.monitor = Monitor::new(time_us);
    }

    /// Whether this is one of the objects.
    pub fn serves(index: u16) -> bool {
        matches!(index, 0x1003 | 0x1005 | 0x1014 | 0x1016 | 0x1017 | 0x1029)
    }

    /// Reads an object.
    ///
    /// # Errors
    /// [`Abort`].
    pub fn read(&self, address: Address) -> Result<Value, Abort> {
        let Configuration { node_id, guard, .. } = self.configuration;
        let emergency = function::SYNC_OR_EMERGENCY + u16::from(node_id);
        let watched = |(node, timeout_us): (u8, u64)| {
            u32::from(node) << 16 | (timeout_us / 1_000).min(0xffff) as u32
        };
        let sends_sync = if guard.is_none() { SENDS_SYNC } else { 0 };
        Ok(match (address.index, address.sub) {
            (0x1003, 0) => Value::new(self.errors.len() as u32, 1),
            (0x1003, sub) if usize::from(sub) <= ERRORS => {
                let error = self.errors.get(usize::from(sub) - 1);
                Value::new((*error.ok_or(Abort::NoData)?).into(), 4)
            }
            (0x1005, 0) => Value::new(sends_sync | u32::from(function::SYNC_OR_EMERGENCY), 4),
            (0x1014, 0) => Value::new(emergency.into(), 4),
            (0x1016, 0) => Value::new(2, 1), // highest sub-index
            (0x1016, 1) => Value::new(guard.map_or(0, watched), 4),
            (0x1016, 2) => Value::new(self.client, 4),
            (0x1017, 0) => Value::new(self.heartbeat_ms.into(), 2),
            (0x1029, 0) => Value::new(1, 1), // highest sub-index
            (0x1029, 1) => Value::new(NO_CHANGE, 1),
            _ => return Err(Abort::NoSubIndex),
        })
    }

    /// Writes a value of the right size.
    ///
    /// # Errors
    /// [`Abort`]; nothing has changed.
    pub fn write(&mut self, address: Address, value: &[u8]) -> Result<(), Abort> {
        let value = number(value);
        match (address.index, address.sub) {
            (0x1003, 0) if value == 0 => self.errors.clear(),
            (0x1003, 0) => return Err(Abort::Range),
            (0x1016, 2) => {
                let node = value >> 16;
                let guard = self.configuration.guard.map_or(0, |(node, _)| node);
                let taken = [self.configuration.node_id, guard].map(u32::from);
                if node > 127 {
                    return Err(Abort::Range);
                }
                // An entry without node or without time is not used.
                if node != 0 && value as u16 != 0 && taken.contains(&node) {
                    return Err(Abort::Incompatible);
                }
                self.client = value;
                self.watch();
            }
            (0x1017, 0) => self.heartbeat_ms = value as u16,
            _ => return Err(Abort::ReadOnly),
        }
        Ok(())
    }

    /// Whether a client may write the object.
    pub fn is_writable(address: Address) -> bool {
        matches!(
            (address.index, address.sub),
            (0x1003 | 0x1017, 0) | (0x1016, 2)
        )
    }
}
