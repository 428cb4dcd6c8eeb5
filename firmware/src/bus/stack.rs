//! One CANopen node: network management (NMT), process data (PDOs), heartbeat and boot-up messages.
//! [`super::sdo`] serves the objects.

use super::filter::{self, Condition, SDO_REQUEST, SDO_RESPONSE, Verdict};
use super::traffic::{NMT, SYNC};
use super::{Dictionary, Listen, Master, TRANSMIT, parameters, sdo};
use crate::watchdog;
use core::sync::atomic::{AtomicBool, Ordering};
use tautrack::bus::network;
use tautrack::can::Frame;
use zencan_node::common::nmt::NmtState;
use zencan_node::common::{AtomicCell, CanId, NodeId};
use zencan_node::object_dict::find_object;
use zencan_node::pdo::{MappingEntry, Pdo};

static OPERATIONAL: AtomicBool = AtomicBool::new(false);

const HEARTBEAT: u16 = 0x700;
const HEARTBEAT_PRODUCER_TIME: u16 = 0x1017;

/// Whether NMT has set this node to "operational". Process data is exchanged only in this state.
pub fn operational() -> bool {
    OPERATIONAL.load(Ordering::Relaxed)
}

/// Objects that a frame wrote.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Written {
    /// None.
    Nothing,
    /// The objects of a PDO.
    ProcessData,
    /// The object with this index and sub-index: the frame is the end of an SDO (service data)
    /// transfer.
    Object(u16, u8),
}

/// Received frame, and what the node did with it.
#[derive(Clone, Copy, Debug)]
pub struct Received {
    /// The frame.
    pub frame: Frame,
    /// What the frame wrote.
    pub wrote: Written,
    /// Time at which the bus task took the frame, microseconds since power-up.
    pub now_us: u64,
}

/// One CANopen node.
pub struct Bus {
    server: sdo::Server,
    dictionary: Dictionary,
    node_id: u8,
    id: NodeId,
    listen: Option<Listen>,
    master: Option<Master>,
    /// Whether the node follows an NMT command.
    commanded: fn(&Frame) -> bool,
    /// Heartbeat period until a client writes another one.
    heartbeat_ms: u16,
    heartbeat_sent_us: u64,
}

impl Bus {
    /// Creates node `node_id` (1 to 127) with `dictionary`. `heartbeat_ms` is the heartbeat period
    /// until a client writes another one. `commanded` returns whether the node follows an NMT
    /// command. Returns `None` if the node id is out of range. Must be called only once, because
    /// the dictionary is static.
    pub fn new(
        dictionary: Dictionary,
        node_id: u8,
        heartbeat_ms: u16,
        listen: Option<Listen>,
        master: Option<Master>,
        commanded: fn(&Frame) -> bool,
    ) -> Option<Self> {
        let id = NodeId::new(node_id).ok()?;
        let bus = Self {
            server: sdo::Server::default(),
            dictionary,
            node_id,
            id,
            listen,
            master,
            commanded,
            heartbeat_ms,
            heartbeat_sent_us: 0,
        };
        bus.reset();
        Some(bus)
    }

    /// Processes one frame; when this returns, [`TRANSMIT`] holds the frames sent in answer.
    pub fn receive(&mut self, frame: Frame, now_us: u64) -> Received {
        let mut wrote = Written::Nothing;
        let condition = self.condition(&frame, now_us);
        let verdict = filter::evaluate(&frame, self.node_id, condition);
        let answer = match verdict {
            Verdict::Drop => None,
            _ => parameters::answer(&frame, self.node_id),
        };
        match (verdict, answer) {
            (_, Some(answer)) | (Verdict::Answer(answer), None) => TRANSMIT.push(answer),
            (Verdict::Pass, None) => {
                if let Some(wrote_objects) = self.follow(&frame, condition.guard_alive, now_us) {
                    wrote = wrote_objects;
                    self.process(now_us);
                }
            }
            (Verdict::Drop, None) => {}
        }
        Received {
            frame,
            wrote,
            now_us,
        }
    }

    /// Updates the monitor of the guard's heartbeat, and returns the conditions for the verdict on
    /// `frame`.
    fn condition(&mut self, frame: &Frame, now_us: u64) -> Condition {
        let mut guard_begins = false;
        let guard_alive = self.master.as_mut().is_some_and(|master| {
            if let Some((node, state)) = network::as_heartbeat(frame)
                && node == master.node_id
            {
                let ready = state == network::NmtState::Operational;
                guard_begins = ready && !master.ready;
                master.ready = ready;
                master.heartbeat.received(now_us);
            }
            let alive = master.heartbeat.alive(now_us);
            master.ready &= alive;
            alive
        });
        if guard_begins {
            // What a client has written before the guard was ready does not count for it.
            let state = self.state();
            self.reset();
            self.apply_listen();
            self.enter(state);
        }
        Condition {
            guard_alive,
            control_runs: watchdog::control_runs(now_us),
            stopped: self.state() == NmtState::Stopped,
        }
    }

    /// Does what `frame` requests. Returns what it wrote; `None` if it is not addressed to this
    /// node.
    fn follow(&mut self, frame: &Frame, guard_alive: bool, now_us: u64) -> Option<Written> {
        match (frame.id(), frame.data()) {
            (NMT, &[command, node])
                if (node == 0 || node == self.node_id) && (self.commanded)(frame) =>
            {
                if matches!(command, 2 | 129 | 130) {
                    self.server = sdo::Server::default();
                }
                match command {
                    1 => self.enter(NmtState::Operational),
                    2 => self.enter(NmtState::Stopped),
                    128 => self.enter(NmtState::PreOperational),
                    129 | 130 => self.reset(),
                    _ => {}
                }
                return Some(Written::Nothing);
            }
            (NMT, _) => return Some(Written::Nothing),
            (SYNC, _) => {
                if self.state() == NmtState::Operational {
                    self.send_process_data();
                }
                return Some(Written::Nothing);
            }
            _ => {}
        }
        let id = CanId::std(frame.id());
        let mut pdos = self.dictionary.receive_pdos.iter();
        if let Some(pdo) = pdos.find(|pdo| pdo.valid() && pdo.cob_id() == id) {
            let operational = self.state() == NmtState::Operational;
            return Some(if operational && store(pdo, frame.data()) {
                Written::ProcessData
            } else {
                Written::Nothing
            });
        }
        if frame.id() != SDO_REQUEST + u16::from(self.node_id) {
            return None;
        }
        let request = frame.data().try_into().ok()?;
        let table = self.dictionary.table;
        let (answer, wrote) = self.server.answer(request, table, guard_alive, now_us);
        self.send_answer(answer);
        Some(wrote.map_or(Written::Nothing, |(index, sub)| Written::Object(index, sub)))
    }

    /// Ends the boot-up, and sends what is due: the heartbeat, if the control task runs, and the
    /// end of a transfer that its client has given up. Object 0x1017 is the period of the heartbeat
    /// in milliseconds, with 0 for no heartbeat.
    pub fn process(&mut self, now_us: u64) {
        if self.state() == NmtState::Bootup {
            self.apply_listen();
            self.send_heartbeat(0, now_us);
            self.enter(NmtState::PreOperational);
        }
        let late = self.server.time_out(now_us);
        self.send_answer(late);
        let state = self.state();
        OPERATIONAL.store(state == NmtState::Operational, Ordering::Relaxed);
        if let Some(due) = self.heartbeat_due_us()
            && now_us >= due
            && watchdog::control_runs(now_us)
        {
            self.send_heartbeat(state as u8, now_us);
        }
    }

    fn state(&self) -> NmtState {
        self.dictionary.state.load()
    }

    fn enter(&self, state: NmtState) {
        self.dictionary.state.store(state);
    }

    /// Restores the parameters of the process data and of the heartbeat, and boots again.
    fn reset(&self) {
        let Dictionary {
            receive_pdos,
            transmit_pdos,
            ..
        } = self.dictionary;
        for pdo in receive_pdos.iter().chain(transmit_pdos) {
            // One that has no defaults is not used.
            pdo.set_valid(false);
            pdo.init_defaults(self.id);
        }
        if let Some(heartbeat) = find_object(self.dictionary.table, HEARTBEAT_PRODUCER_TIME) {
            // Cannot fail: the object has two bytes.
            let _ = heartbeat.write(0, &self.heartbeat_ms.to_le_bytes());
        }
        self.enter(NmtState::Bootup);
    }

    /// Sends the process data that are due on a SYNC. None is sent on an event: no object reports
    /// one.
    fn send_process_data(&self) {
        for pdo in self.dictionary.transmit_pdos {
            if pdo.sync_update()
                && let CanId::Std(id) = pdo.cob_id()
            {
                let (data, length) = payload(pdo);
                let frame = Frame::new(id, data.get(..length).unwrap_or_default());
                TRANSMIT.push(frame.unwrap_or_default());
            }
        }
    }

    fn send_answer(&self, answer: Option<[u8; 8]>) {
        let id = SDO_RESPONSE + u16::from(self.node_id);
        let frame = answer.and_then(|answer| Frame::new(id, &answer));
        if let Some(frame) = frame {
            TRANSMIT.push(frame);
        }
    }

    /// Returns when the next heartbeat is due, us since power-up; `None` if it is disabled. A new
    /// period in 0x1017 counts from the last heartbeat sent.
    pub(super) fn heartbeat_due_us(&self) -> Option<u64> {
        let period = find_object(self.dictionary.table, HEARTBEAT_PRODUCER_TIME)?
            .read_u16(0)
            .ok()?;
        (period != 0).then(|| self.heartbeat_sent_us + u64::from(period) * 1_000)
    }

    fn send_heartbeat(&mut self, state: u8, now_us: u64) {
        self.heartbeat_sent_us = now_us;
        if let Some(frame) = Frame::new(HEARTBEAT + u16::from(self.node_id), &[state]) {
            TRANSMIT.push(frame);
        }
    }

    /// Writes this robot's COB-ID into the receive PDO. A reset of communication restores the
    /// generated COB-IDs, so this is repeated in every boot-up.
    fn apply_listen(&self) {
        if let Some(listen) = self.listen
            && let Some(parameter) = find_object(self.dictionary.table, listen.parameter)
        {
            // Cannot fail: the value has four bytes, and the NMT state is boot-up.
            let _ = parameter.write(1, &u32::from(listen.id).to_le_bytes());
        }
    }
}

/// The objects in a PDO. Some objects of the parameters panic if they are read with no bytes, so an
/// entry without bytes is left out.
fn mapped(pdo: &Pdo<'static>) -> impl Iterator<Item = MappingEntry<'static>> {
    let count = usize::from(pdo.valid_maps.load());
    let entries = pdo.mapping_params.iter().take(count);
    entries
        .map_while(AtomicCell::load)
        .filter(|entry| entry.length > 0)
}

/// Writes what a PDO carries to its objects. Returns whether it did: a PDO without objects, or with
/// fewer bytes than its objects have, writes none of them.
fn store(pdo: &Pdo<'static>, mut data: &[u8]) -> bool {
    let length: usize = mapped(pdo).map(|entry| usize::from(entry.length)).sum();
    if length == 0 || data.len() < length {
        return false;
    }
    for entry in mapped(pdo) {
        if let Some((value, rest)) = data.split_at_checked(usize::from(entry.length)) {
            // Fails if a client has mapped an object that cannot be written, or a part of one.
            let _ = entry.object.data.write(entry.sub, value);
            data = rest;
        }
    }
    true
}

/// Reads what a PDO carries from its objects. Returns it with its length.
fn payload(pdo: &Pdo<'static>) -> ([u8; 8], usize) {
    let mut data = [0; 8];
    let mut length = 0;
    for entry in mapped(pdo) {
        let end = length + usize::from(entry.length);
        let Some(place) = data.get_mut(length..end) else {
            break;
        };
        // Fails if a client has mapped an object that cannot be read. Its bytes are 0 then.
        let _ = entry.object.data.read(entry.sub, 0, place);
        length = end;
    }
    (data, length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heartbeats() -> usize {
        core::iter::from_fn(|| TRANSMIT.pop())
            .filter(|frame| frame.id() == HEARTBEAT + 5)
            .count()
    }

    #[test]
    fn a_node_whose_control_task_stands_sends_neither_heartbeat_nor_process_data() {
        let dictionary = crate::roles::axle::DICTIONARY;
        let mut bus = Bus::new(dictionary, 5, 50, None, None, |_| true).expect("a node");
        let mut now_us = 0;
        // Simulates one second, with the control task running or not.
        let mut second = |runs: bool| {
            let mut sent = 0;
            for _ in 0..1_000 {
                now_us += 1_000;
                if runs {
                    watchdog::control_ran(now_us);
                }
                bus.process(now_us);
                sent += heartbeats();
            }
            let sync = Frame::new(SYNC, &[]).expect("a frame");
            let answered = bus.condition(&sync, now_us).control_runs;
            (sent, answered)
        };
        assert_eq!(
            second(true),
            (20, true),
            "one every 50 ms, boot-up included"
        );
        // One heartbeat may be due before the control task counts as stopped.
        let (sent, answered) = second(false);
        assert!(sent <= 1 && !answered, "{sent}");
        assert_eq!(second(true), (20, true));
    }
}
