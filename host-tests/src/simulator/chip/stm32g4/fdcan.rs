//! The CAN controller: message RAM, receive FIFO, transmit queue and error states (RM0440, 44.3
//! and 44.4).
//!
//! On a good bus a frame takes no time. Without one, the controller repeats its frame, counts the
//! errors, and gets passive and off as ISO 11898-1 demands. Errors of received frames are not
//! modelled.

use super::{CORE_HZ, FDCAN, MESSAGES, State};
use std::collections::VecDeque;
use tautrack::can::Frame;

const CONTROL: u32 = FDCAN + 0x18;
/// Error counters.
pub const CAN_ERRORS: u32 = FDCAN + 0x40;
/// Protocol status.
pub const CAN_STATUS: u32 = FDCAN + 0x44;
const FLAGS: u32 = FDCAN + 0x50;
const FIFO_STATUS: u32 = FDCAN + 0x90;
const WAITING: u32 = FDCAN + 0xc8;
const SENT: u32 = FDCAN + 0xd4;
const CANCELLED: u32 = FDCAN + 0xd8;

/// Bits of [`CAN_STATUS`]: passive, warning and off.
pub const PASSIVE: u32 = 1 << 5;
const WARNING: u32 = 1 << 6;
/// Bus-off, in [`CAN_STATUS`].
pub const BUS_OFF: u32 = 1 << 7;
const INITIALISATION: u32 = 1;
/// Interrupt flags of a change of passive, warning and off.
const CHANGES: [(u32, u32); 3] = [(PASSIVE, 1 << 17), (WARNING, 1 << 18), (BUS_OFF, 1 << 19)];
/// Last error code "no error since the last read".
const NO_CHANGE: u32 = 7;
/// Buffers of the transmit queue, and of the receive FIFO.
const BUFFERS: u32 = 3;

/// Core clocks of a bit.
const BIT: u64 = CORE_HZ / 1_000_000;
/// Duration of a frame of eight bytes that nobody acknowledges, with its error frame.
const WHOLE_ATTEMPT: u64 = 130 * BIT;
/// Duration of a frame whose first bit fails, with its error frame.
const FAILED_ATTEMPT: u64 = 25 * BIT;
/// 129 times 11 recessive bits.
const RECOVERY: u64 = 129 * 11 * BIT;

/// What the chip's transceiver is connected to.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Wiring {
    /// Other nodes, which acknowledge its frames.
    #[default]
    Good,
    /// No other node.
    Alone,
    /// CANH and CANL are shorted: a dominant bit is read back as recessive.
    Shorted,
}

/// State of the controller beyond its registers.
#[derive(Default)]
pub struct Controller {
    wiring: Wiring,
    transmit_errors: u32,
    /// Clocks at which the frame on the bus fails, and at which bus-off ends.
    failure: Option<u64>,
    recovered: Option<u64>,
    /// Frames that arrive at these clocks, whether the FIFO has room or not.
    arriving: VecDeque<(u64, Frame)>,
    lost: u32,
}

impl Controller {
    /// State after a reset of the chip: only the wiring stays.
    pub(super) fn after_reset(&self) -> Self {
        Self {
            wiring: self.wiring,
            ..Self::default()
        }
    }
}

impl State {
    /// A write to the register with the requests.
    pub(super) fn request(&mut self, buffers: u32) {
        for (register, value) in [
            (WAITING, self.get(WAITING) | buffers),
            (SENT, self.get(SENT) & !buffers),
            (CANCELLED, self.get(CANCELLED) & !buffers),
        ] {
            self.set(register, value);
        }
        self.transmit();
    }

    /// A write to the register with the cancellations.
    pub(super) fn cancel(&mut self, buffers: u32) {
        let cancelled = self.get(WAITING) & buffers;
        self.set(WAITING, self.get(WAITING) & !buffers);
        self.set(CANCELLED, self.get(CANCELLED) | cancelled);
    }

    /// A write to the control register: software ends the initialisation after a bus-off.
    pub(super) fn control_can(&mut self, value: u32) {
        let ended = self.get(CONTROL) & !value & INITIALISATION != 0;
        if ended && self.get(CAN_STATUS) & BUS_OFF != 0 {
            self.can.recovered = Some(self.clock + RECOVERY);
        }
    }

    /// State of the transmit queue: full, and the next free buffer.
    pub(super) fn queue_status(&self) -> u32 {
        let waiting = self.get(WAITING);
        let free = (0..BUFFERS).find(|buffer| waiting & 1 << buffer == 0);
        free.map_or(1 << 21, |buffer| buffer << 16)
    }

    /// Protocol status; reading it clears the last error code.
    pub(super) fn can_status(&mut self) -> u32 {
        let status = self.get(CAN_STATUS);
        self.set(CAN_STATUS, status | NO_CHANGE);
        status
    }

    /// Advances the controller to the clock. Returns the clock of its next event.
    pub(super) fn advance_can(&mut self) -> u64 {
        let clock = self.clock;
        let due = |at: Option<u64>| at.is_some_and(|at| at <= clock);
        if due(self.can.failure) {
            self.can.failure = None;
            self.fail();
        }
        if due(self.can.recovered) {
            self.can.recovered = None;
            self.can.transmit_errors = 0;
            self.show_errors(NO_CHANGE);
        }
        while due(self.can.arriving.front().map(|(at, _)| *at)) {
            let stored = self.can.arriving.pop_front();
            if !stored.is_some_and(|(_, frame)| self.store(frame)) {
                self.can.lost += 1;
                self.raise(1 << 2);
            }
        }
        self.transmit();
        self.receive();
        let arrival = self.can.arriving.front().map(|(at, _)| *at);
        [self.can.failure, self.can.recovered, arrival]
            .into_iter()
            .flatten()
            .min()
            .unwrap_or(u64::MAX)
    }

    fn takes_part(&self) -> bool {
        self.get(CONTROL) & INITIALISATION == 0 && self.get(CAN_STATUS) & BUS_OFF == 0
    }

    /// Sends all waiting frames, the most urgent first, if the bus is good.
    fn transmit(&mut self) {
        if !self.takes_part() || self.get(WAITING) == 0 || self.can.failure.is_some() {
            return;
        }
        let duration = match self.can.wiring {
            Wiring::Good => {
                while let Some(buffer) = self.most_urgent() {
                    self.send_buffer(buffer);
                }
                return;
            }
            Wiring::Alone => WHOLE_ATTEMPT,
            Wiring::Shorted => FAILED_ATTEMPT,
        };
        self.can.failure = Some(self.clock + duration);
    }

    fn most_urgent(&self) -> Option<u32> {
        let waiting = self.get(WAITING);
        (0..BUFFERS)
            .filter(|buffer| waiting & 1 << buffer != 0)
            .min_by_key(|buffer| self.get(element(*buffer)))
    }

    fn send_buffer(&mut self, buffer: u32) {
        let element = element(buffer);
        let length = (self.get(element + 4) >> 16 & 15) as usize;
        let data: Vec<u8> = (0..2)
            .flat_map(|word| self.get(element + 8 + 4 * word).to_le_bytes())
            .take(length)
            .collect();
        let id = (self.get(element) >> 18 & 0x7ff) as u16;
        let frame = Frame::new(id, &data).expect("a classic frame");
        self.sent.push((self.clock, frame));
        self.set(WAITING, self.get(WAITING) & !(1 << buffer));
        self.set(SENT, self.get(SENT) | 1 << buffer);
        self.can.transmit_errors = self.can.transmit_errors.saturating_sub(1);
        self.show_errors(0);
        self.raise(1 << 7);
    }

    /// Counts the failure of the frame on the bus.
    fn fail(&mut self) {
        let (code, counts) = match self.can.wiring {
            Wiring::Good => return,
            // Acknowledge error: a passive node does not count it.
            Wiring::Alone => (3, self.get(CAN_STATUS) & PASSIVE == 0),
            // A dominant bit was recessive.
            Wiring::Shorted => (5, true),
        };
        self.can.transmit_errors += 8 * u32::from(counts);
        self.show_errors(code);
        if self.get(CAN_STATUS) & BUS_OFF != 0 {
            self.set(CONTROL, self.get(CONTROL) | INITIALISATION);
        }
    }

    /// Shows counter and state of the errors with the code of the last one.
    fn show_errors(&mut self, code: u32) {
        let errors = self.can.transmit_errors;
        self.set(CAN_ERRORS, errors.min(255));
        let old = self.get(CAN_STATUS);
        let mut status = code;
        for (limit, bit) in [(96, WARNING), (128, PASSIVE), (256, BUS_OFF)] {
            if errors >= limit {
                status |= bit;
            }
        }
        self.set(CAN_STATUS, status);
        for (bit, flag) in CHANGES {
            if (old ^ status) & bit != 0 {
                self.raise(flag);
            }
        }
    }

    fn raise(&mut self, flag: u32) {
        self.set(FLAGS, self.get(FLAGS) | flag);
    }

    /// Puts the oldest frame that waits on the bus into an empty FIFO 0.
    pub(super) fn receive(&mut self) {
        let fill = self.get(FIFO_STATUS) & 15;
        if fill == 0
            && self.takes_part()
            && let Some(frame) = self.received.pop_front()
        {
            self.store(frame);
        }
    }

    /// Puts a frame into FIFO 0. Returns whether it had room.
    fn store(&mut self, frame: Frame) -> bool {
        let status = self.get(FIFO_STATUS);
        let (fill, first) = (status & 15, status >> 8 & 3);
        if fill == BUFFERS || !self.takes_part() {
            return false;
        }
        let element = MESSAGES + 0xb0 + 72 * ((first + fill) % BUFFERS);
        let mut data = [0; 8];
        data[..frame.data().len()].copy_from_slice(frame.data());
        self.set(element, u32::from(frame.id()) << 18);
        self.set(element + 4, (frame.data().len() as u32) << 16);
        for word in 0..2 {
            let bytes = data[4 * word..4 * word + 4].try_into().expect("a word");
            self.set(element + 8 + 4 * word as u32, u32::from_le_bytes(bytes));
        }
        self.set(FIFO_STATUS, first << 8 | (fill + 1));
        self.raise(1);
        true
    }

    /// Frees the element of FIFO 0 that was read.
    pub(super) fn acknowledge(&mut self, index: u32) {
        let fill = self.get(FIFO_STATUS) & 15;
        let first = (index + 1) % BUFFERS;
        self.set(FIFO_STATUS, first << 8 | fill.saturating_sub(1));
    }

    /// Connects the transceiver.
    pub(super) fn wire(&mut self, wiring: Wiring) {
        self.can.wiring = wiring;
        self.changed = true;
    }

    /// Sends frames back to back, without stuffed bits.
    pub(super) fn burst(&mut self, frames: impl IntoIterator<Item = Frame>) {
        let mut at = self.clock;
        for frame in frames {
            at += (47 + 8 * frame.data().len() as u64) * BIT;
            self.can.arriving.push_back((at, frame));
        }
        self.changed = true;
    }

    /// Frames that came while the FIFO was full.
    pub(super) fn lost(&self) -> u32 {
        self.can.lost
    }
}

/// Address of an element of the transmit queue.
fn element(buffer: u32) -> u32 {
    MESSAGES + 0x278 + 72 * buffer
}
