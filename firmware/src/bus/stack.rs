//! Wraps the CANopen stack, and sends the heartbeat and boot-up messages, which the stack does not
//! send as CiA 301 requires.

use super::filter::{self, Condition, Verdict};
use super::{Dictionary, Listen, Master, TRANSMIT, parameters};
use crate::watchdog;
use core::sync::atomic::{AtomicBool, Ordering};
use tautrack::bus::network;
use tautrack::can::Frame;
use zencan_node::common::nmt::NmtState;
use zencan_node::common::{CanId, CanMessage, NodeId};
use zencan_node::object_dict::find_object;
use zencan_node::{Callbacks, Node};

static OPERATIONAL: AtomicBool = AtomicBool::new(false);

const HEARTBEAT: u16 = 0x700;
const HEARTBEAT_PRODUCER_TIME: u16 = 0x1017;

/// Whether NMT has set this node to "operational". Process data is exchanged only in this state.
pub fn operational() -> bool {
    OPERATIONAL.load(Ordering::Relaxed)
}

/// Received frame, and what the stack did with it.
#[derive(Clone, Copy, Debug)]
pub struct Received {
    /// The frame.
    pub frame: Frame,
    /// The frame wrote objects: as process data, or as the end of an SDO (service data) transfer.
    pub wrote: bool,
    /// Index of the object that the frame addressed by SDO.
    pub sdo_index: Option<u16>,
    /// Time at which the bus task took the frame, microseconds since power-up.
    pub now_us: u64,
}

/// One CANopen node.
pub struct Bus {
    node: Node<'static>,
    dictionary: Dictionary,
    node_id: u8,
    listen: Option<Listen>,
    master: Option<Master>,
    heartbeat_sent_us: u64,
}

impl Bus {
    /// Creates node `node_id` (1 to 127) with `dictionary`. `heartbeat_ms` is the heartbeat period
    /// until a client writes another one. Returns `None` if the node id is out of range. Must be
    /// called only once, because the dictionary is static.
    pub fn new(
        dictionary: Dictionary,
        node_id: u8,
        heartbeat_ms: u16,
        listen: Option<Listen>,
        master: Option<Master>,
    ) -> Option<Self> {
        let id = NodeId::new(node_id).ok()?;
        let heartbeat = find_object(dictionary.table, HEARTBEAT_PRODUCER_TIME)?;
        // The stack reads the period once, here; a period other than 0 would make it send its own
        // heartbeats.
        heartbeat.write(0, &0_u16.to_le_bytes()).ok()?;
        let node = Node::new(
            id,
            Callbacks::new(),
            dictionary.mailbox,
            dictionary.state,
            dictionary.table,
        );
        heartbeat.write(0, &heartbeat_ms.to_le_bytes()).ok()?;
        Some(Self {
            node,
            dictionary,
            node_id,
            listen,
            master,
            heartbeat_sent_us: 0,
        })
    }

    /// Processes one frame; when this returns, [`TRANSMIT`] holds the frames sent in answer. It
    /// takes one frame at a time, because each of the stack's mailboxes holds one.
    pub fn receive(&mut self, frame: Frame, now_us: u64) -> Received {
        let mut wrote = false;
        let condition = self.condition(&frame, now_us);
        let answer = parameters::answer(&frame, self.node_id);
        if let Some(answer) = answer {
            TRANSMIT.push(answer);
        }
        match filter::evaluate(&frame, self.node_id, condition) {
            _ if answer.is_some() => {}
            Verdict::Pass => {
                let message = CanMessage::new(CanId::std(frame.id()), frame.data());
                // An error means that the frame is not addressed to this node.
                if self.dictionary.mailbox.store_message(message).is_ok() {
                    wrote = self.process(now_us);
                }
            }
            Verdict::Drop => {}
            Verdict::Answer(answer) => TRANSMIT.push(answer),
        }
        Received {
            frame,
            wrote,
            sdo_index: filter::sdo_index(&frame, self.node_id),
            now_us,
        }
    }

    /// Updates the monitor of the guard's heartbeat, and returns the conditions for the verdict on
    /// `frame`.
    fn condition(&mut self, frame: &Frame, now_us: u64) -> Condition {
        let guard_alive = self.master.as_mut().is_some_and(|master| {
            if network::as_heartbeat(frame).is_some_and(|(node, _)| node == master.node_id) {
                master.heartbeat.received(now_us);
            }
            master.heartbeat.alive(now_us)
        });
        Condition {
            guard_alive,
            control_runs: watchdog::control_runs(now_us),
        }
    }

    /// Runs the stack, and sends the heartbeat if it is due and the control task runs. Object
    /// 0x1017 is its period in milliseconds, with 0 for no heartbeat. Returns whether objects were
    /// written.
    pub fn process(&mut self, now_us: u64) -> bool {
        let mut wrote = false;
        loop {
            let booting = self.node.nmt_state() == NmtState::Bootup;
            if booting {
                self.apply_listen();
                self.send_heartbeat(0, now_us);
            }
            wrote |= self.node.process(now_us);
            while let Some(message) = self.dictionary.mailbox.next_transmit_message() {
                let id = message.id().raw() as u16;
                // The stack's boot-up message carries the state after boot-up, where CiA 301
                // requires 0: `send_heartbeat(0)` above sends the correct one.
                if id != HEARTBEAT + u16::from(self.node_id)
                    && let Some(frame) = Frame::new(id, message.data())
                {
                    TRANSMIT.push(frame);
                }
            }
            if self.node.nmt_state() != NmtState::Bootup {
                break;
            }
        }
        OPERATIONAL.store(
            self.node.nmt_state() == NmtState::Operational,
            Ordering::Relaxed,
        );
        if let Some(due) = self.heartbeat_due_us()
            && now_us >= due
            && watchdog::control_runs(now_us)
        {
            self.send_heartbeat(self.node.nmt_state() as u8, now_us);
        }
        wrote
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bus::traffic::SYNC;

    fn heartbeats() -> usize {
        core::iter::from_fn(|| TRANSMIT.pop())
            .filter(|frame| frame.id() == HEARTBEAT + 5)
            .count()
    }

    #[test]
    fn a_node_whose_control_task_stands_sends_neither_heartbeat_nor_process_data() {
        let dictionary = crate::roles::axle::DICTIONARY;
        let mut bus = Bus::new(dictionary, 5, 50, None, None).expect("a node");
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
