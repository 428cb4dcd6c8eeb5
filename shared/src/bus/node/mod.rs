//! A `CANopen` node (CiA 301) as a value: network management, heartbeat, SYNC, process data (PDOs)
//! and service data (SDOs). It has no I/O, and no clock but its inputs.
//!
//! * `communication`: the objects of error history, emergency and heartbeats
//! * `controller`: errors of the CAN controller
//! * `dictionary`: the table of objects, and their values
//! * `process_data`: the PDOs and their parameters
//! * `sdo`: the SDO server

mod communication;
mod controller;
mod dictionary;
mod process_data;
#[allow(clippy::trivially_copy_pass_by_ref)] // a pointer is smaller than the eight bytes
#[allow(clippy::verbose_bit_mask)] // the standard numbers the bits
mod sdo;

pub use controller::Condition;
pub use dictionary::{
    Abort, Access, Address, Dictionary, Field, Number, PdoDefaults, Row, Table, Value, Values,
    number,
};

use super::heartbeat::Monitor;
use super::network::{self, Emergency, NmtCommand, NmtState, function};
use crate::can::Frame;
use crate::fault_log::{Circumstances, FaultLog};
use communication::Communication;
use controller::{Controller, QUIET};
use process_data::Pdos;
use sdo::{Objects, Server};

const SDO_REQUEST: u16 = 0x600;
const SDO_RESPONSE: u16 = 0x580;
/// Error code: a receive PDO had too few bytes, and was not used.
const PDO_TOO_SHORT: u16 = 0x8210;

/// Command of the network management.
const RESET_NODE: u8 = NmtCommand::ResetNode as u8;

/// Time without a control tick after which a node answers no SYNC and sends no heartbeat, us: what
/// it would send is old.
const CONTROL_TIMEOUT_US: u64 = 20_000;

/// What a node is told about its network at start.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Configuration {
    /// Node id, 1 to 127.
    pub node_id: u8,
    /// Period of the heartbeat until a client writes another one, ms.
    pub heartbeat_ms: u16,
    /// Node id of the guard that the node follows, and the time, us, after which a guard without a
    /// heartbeat is lost; `None` for the guard itself, which is the master of the network.
    pub guard: Option<(u8, u64)>,
    /// Receive PDO, counted from 0, that listens to another node's identifier.
    pub listens: Option<(usize, u16)>,
}

/// The guard that a node follows.
#[derive(Clone, Copy, Debug)]
struct Guard {
    node_id: u8,
    heartbeat: Monitor,
    /// The newest heartbeat says that the guard no longer waits for its drives.
    ready: bool,
}

/// A node's part of the bus. Every method passes the frames that it sends to `send`.
#[derive(Clone, Debug)]
pub struct Core {
    configuration: Configuration,
    guard: Option<Guard>,
    state: NmtState,
    pdos: Pdos,
    server: Server,
    communication: Communication,
    /// Ticks until a receive PDO that is too short is reported again.
    short: u16,
    controller: Controller,
    heartbeat_us: u64,
    ticked_us: u64,
    restarts: bool,
}

impl Core {
    /// Creates a node, for [`Self::boot`].
    pub fn new(configuration: Configuration) -> Self {
        let guard = configuration.guard.map(|(node_id, timeout_us)| Guard {
            node_id,
            heartbeat: Monitor::new(timeout_us),
            ready: false,
        });
        Self {
            configuration,
            guard,
            state: NmtState::BootUp,
            pdos: Pdos::unused(),
            server: Server::default(),
            communication: Communication::new(configuration),
            short: 0,
            controller: Controller::default(),
            heartbeat_us: 0,
            ticked_us: 0,
            restarts: false,
        }
    }

    /// Returns the state of the network management.
    pub fn state(&self) -> NmtState {
        self.state
    }

    /// Returns whether the network management has reset the node. Its program then restarts it, as
    /// after power-up, once it has left operation.
    pub fn restarts(&self) -> bool {
        self.restarts
    }

    /// Returns whether the guard is alive. It is not for the guard itself.
    pub fn is_guarded(&self, now_us: u64) -> bool {
        let guard = self.guard.as_ref();
        guard.is_some_and(|guard| guard.heartbeat.alive(now_us))
    }

    /// Follows a frame from the bus.
    pub fn receive<D: Dictionary>(
        &mut self,
        frame: &Frame,
        now_us: u64,
        dictionary: &mut D,
        send: &mut impl FnMut(Frame),
    ) {
        let guarded = self.note_heartbeat(frame, now_us, dictionary.table());
        let node = self.configuration.node_id;
        match (frame.id(), frame.data()) {
            // The master follows its own commands, by `command`. Others may reset it alone, while
            // it commands nobody: so saved settings take effect.
            (function::NMT, &[RESET_NODE, addressed])
                if self.guard.is_none() && addressed == node =>
            {
                self.restarts |= dictionary.may_restart();
            }
            (function::NMT, &[command, addressed])
                if self.guard.is_some() && (addressed == 0 || addressed == node) =>
            {
                self.command(command, now_us, dictionary.table(), send);
            }
            (function::NMT, _) => {}
            (function::SYNC_OR_EMERGENCY, _) => self.synchronize(now_us, dictionary, send),
            (id, data) if id == SDO_REQUEST + u16::from(node) => {
                // CiA 301: an SDO has eight bytes, and a stopped node answers none.
                let Ok(request) = data.try_into() else { return };
                if self.state == NmtState::Stopped {
                    return;
                }
                let answer = self.serve(request, guarded, now_us, dictionary);
                self.answer(answer, send);
            }
            (id, data) => {
                let mut pdos = self.pdos.receive.iter_mut();
                let Some(pdo) = pdos.find(|pdo| pdo.is(id)) else {
                    return;
                };
                if self.state != NmtState::Operational {
                    return;
                }
                if pdo.is_empty() {
                    return;
                }
                if !pdo.fits(data) {
                    // A client may send it for ever.
                    if core::mem::replace(&mut self.short, QUIET) == 0 {
                        self.report(PDO_TOO_SHORT, &Circumstances::default(), send);
                    }
                    return;
                }
                if pdo.waits_for_sync() {
                    pdo.keep(*frame, now_us);
                } else {
                    pdo.store(data, dictionary.values_mut());
                    dictionary.received(id, pdo.objects(), now_us);
                }
            }
        }
    }

    /// Follows a command of the network management to this node.
    pub fn command(
        &mut self,
        command: u8,
        now_us: u64,
        table: &Table,
        send: &mut impl FnMut(Frame),
    ) {
        if matches!(command, 2 | RESET_NODE | 130) {
            self.server = Server::default();
        }
        match command {
            1 => self.state = NmtState::Operational,
            2 => self.state = NmtState::Stopped,
            128 => self.state = NmtState::PreOperational,
            RESET_NODE => self.restarts = true,
            130 => self.boot(now_us, table, send),
            _ => {}
        }
        if self.state != NmtState::Operational {
            // A set-point from before a stop does not act after the next start.
            for pdo in &mut self.pdos.receive {
                pdo.take();
            }
        }
    }

    /// Restores the parameters of communication, and sends the boot-up message.
    pub fn boot(&mut self, now_us: u64, table: &Table, send: &mut impl FnMut(Frame)) {
        self.restore(table);
        self.state = NmtState::BootUp;
        self.beat(now_us, send);
        self.state = NmtState::PreOperational;
    }

    /// Follows a SYNC: sends the process data that are due, and writes those that wait for it.
    pub fn synchronize<D: Dictionary>(
        &mut self,
        now_us: u64,
        dictionary: &mut D,
        send: &mut impl FnMut(Frame),
    ) {
        let ticks = now_us.saturating_sub(self.ticked_us) <= CONTROL_TIMEOUT_US;
        if self.state != NmtState::Operational || !ticks {
            return;
        }
        for pdo in &mut self.pdos.transmit {
            pdo.on_sync(dictionary, now_us)
                .into_iter()
                .for_each(&mut *send);
        }
        for pdo in &mut self.pdos.receive {
            if let Some(frame) = pdo.take() {
                pdo.store(frame.data(), dictionary.values_mut());
                dictionary.received(frame.id(), pdo.objects(), now_us);
            }
        }
    }

    /// Sends what is due in a control tick: the heartbeat, process data that wait for an event, and
    /// the messages of SDO transfers.
    pub fn tick<D: Dictionary>(
        &mut self,
        now_us: u64,
        dictionary: &mut D,
        send: &mut impl FnMut(Frame),
    ) {
        self.ticked_us = now_us;
        self.short = self.short.saturating_sub(1);
        if self.communication.loses_client(now_us) {
            dictionary.lost_client();
        }
        let late = self.server.time_out(now_us);
        self.answer(late, send);
        let objects = Objects {
            dictionary,
            pdos: &mut self.pdos,
            communication: &mut self.communication,
            guarded: false,
        };
        for segment in self.server.segments(&objects) {
            self.answer(Some(segment), send);
        }
        if self.state == NmtState::Operational {
            for pdo in &mut self.pdos.transmit {
                pdo.on_event(dictionary, now_us)
                    .into_iter()
                    .for_each(&mut *send);
            }
        }
        let period_us = u64::from(self.communication.heartbeat_ms) * 1_000;
        if period_us != 0 && now_us >= self.heartbeat_us + period_us {
            self.beat(now_us, send);
        }
    }

    /// Updates the monitors of heartbeats. Returns whether the guard is alive.
    fn note_heartbeat(&mut self, frame: &Frame, now_us: u64, table: &Table) -> bool {
        let heartbeat = network::as_heartbeat(frame);
        if let Some((node, _)) = heartbeat {
            self.communication.note_heartbeat(node, now_us);
        }
        let Some(guard) = &mut self.guard else {
            return false;
        };
        let mut begins = false;
        if let Some((node, state)) = heartbeat
            && node == guard.node_id
        {
            let ready = state == NmtState::Operational;
            begins = ready && !guard.ready;
            guard.ready = ready;
            guard.heartbeat.received(now_us);
        }
        let alive = guard.heartbeat.alive(now_us);
        guard.ready &= alive;
        if begins {
            // What a client has written before the guard was ready does not count for it.
            self.restore(table);
        }
        alive
    }

    /// Restores the parameters of the process data and of the heartbeat.
    fn restore(&mut self, table: &Table) {
        let Configuration {
            node_id, listens, ..
        } = self.configuration;
        self.pdos.restore(node_id, table);
        if let Some((number, id)) = listens
            && let Some(pdo) = self.pdos.receive.get_mut(number)
        {
            pdo.listen(id);
        }
        self.communication.restore();
    }

    fn serve<D: Dictionary>(
        &mut self,
        request: [u8; 8],
        guarded: bool,
        now_us: u64,
        dictionary: &mut D,
    ) -> Option<[u8; 8]> {
        let mut objects = Objects {
            dictionary,
            pdos: &mut self.pdos,
            communication: &mut self.communication,
            guarded,
        };
        self.server.answer(&request, &mut objects, now_us)
    }

    /// Adds an error to the history, with what was measured, and sends its emergency message, which
    /// a stopped node does not. Code 0 says that there is no error any more.
    pub fn report(&mut self, code: u16, measured: &Circumstances, send: &mut impl FnMut(Frame)) {
        if code != 0 {
            let time = (self.ticked_us / 1_000) as u32;
            self.communication.errors.add(code, time, measured);
        }
        if self.state != NmtState::Stopped {
            let node = self.configuration.node_id;
            send(network::emergency(Emergency { node, code }));
        }
    }

    /// Takes the condition of the CAN controller in this tick.
    pub fn note_bus(&mut self, condition: Condition, send: &mut impl FnMut(Frame)) {
        if let Some(code) = self.controller.tick(condition) {
            self.report(code, &Circumstances::default(), send);
        }
    }

    /// Returns the history of errors.
    pub fn errors(&mut self) -> &mut FaultLog {
        &mut self.communication.errors
    }

    fn answer(&self, answer: Option<[u8; 8]>, send: &mut impl FnMut(Frame)) {
        let id = SDO_RESPONSE + u16::from(self.configuration.node_id);
        let frame = answer.and_then(|answer| Frame::new(id, &answer));
        frame.into_iter().for_each(send);
    }

    fn beat(&mut self, now_us: u64, send: &mut impl FnMut(Frame)) {
        self.heartbeat_us = now_us;
        send(network::heartbeat(self.configuration.node_id, self.state));
    }
}
