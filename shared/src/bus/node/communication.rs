//! Objects of communication (0x1003 to 0x1029, CiA 301) that are no parameters of process data:
//! error history, SYNC, emergency, heartbeats, and the behaviour on errors. And what was measured
//! when the errors of the history came (0x2021).

use super::Configuration;
use super::dictionary::{Abort, Address, Value, number};
use crate::bus::heartbeat::Monitor;
use crate::bus::network::function;
use crate::fault_log::{ENTRIES, Entry, FaultLog};

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
    /// History of errors.
    pub errors: FaultLog,
    /// Number of the error that object 0x2021 shows; 1 is the newest one.
    shown: u8,
}

impl Communication {
    pub fn new(configuration: Configuration) -> Self {
        Self {
            configuration,
            heartbeat_ms: 0,
            client: 0,
            monitor: Monitor::new(0),
            errors: FaultLog::default(),
            shown: 1,
        }
    }

    /// Restores the values at start, but not the history.
    pub fn restore(&mut self) {
        self.heartbeat_ms = self.configuration.heartbeat_ms;
        self.client = 0;
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
        matches!(
            index,
            0x1003 | 0x1005 | 0x1014 | 0x1016 | 0x1017 | 0x1029 | 0x2021
        )
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
            (0x1003, sub) if usize::from(sub) <= ENTRIES => {
                let error = self.errors.get(usize::from(sub) - 1);
                Value::new(error.ok_or(Abort::NoData)?.error(), 4)
            }
            (0x1005, 0) => Value::new(sends_sync | u32::from(function::SYNC_OR_EMERGENCY), 4),
            (0x1014, 0) => Value::new(emergency.into(), 4),
            (0x1016, 0) => Value::new(2, 1), // highest sub-index
            (0x1016, 1) => Value::new(guard.map_or(0, watched), 4),
            (0x1016, 2) => Value::new(self.client, 4),
            (0x1017, 0) => Value::new(self.heartbeat_ms.into(), 2),
            (0x1029, 0) => Value::new(1, 1), // highest sub-index
            (0x1029, 1) => Value::new(NO_CHANGE, 1),
            (0x2021, sub) => self.record(sub).ok_or(Abort::NoSubIndex)?,
            _ => return Err(Abort::NoSubIndex),
        })
    }

    /// An entry of the record of an error: zeros where the history ends.
    fn record(&self, sub: u8) -> Option<Value> {
        let entry = self.errors.get(usize::from(self.shown) - 1);
        let Entry {
            code,
            reset,
            time,
            supply_voltage,
            current,
            velocity,
        } = entry.copied().unwrap_or_default();
        let (number, length) = match sub {
            0 => (7, 1), // highest sub-index
            1 => (self.shown.into(), 1),
            2 => (code.into(), 2),
            3 => (reset.into(), 1),
            4 => (time, 4),
            5 => (supply_voltage.into(), 2),
            6 => (current.cast_unsigned().into(), 2),
            7 => (velocity.cast_unsigned(), 4),
            _ => return None,
        };
        Some(Value::new(number, length))
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
            (0x2021, 1) if (1..=ENTRIES as u32).contains(&value) => self.shown = value as u8,
            (0x2021, 1) => return Err(Abort::Range),
            _ => return Err(Abort::ReadOnly),
        }
        Ok(())
    }

    /// Whether a client may write the object.
    pub fn is_writable(address: Address) -> bool {
        matches!(
            (address.index, address.sub),
            (0x1003 | 0x1017, 0) | (0x1016, 2) | (0x2021, 1)
        )
    }
}
