//! Traffic of a busy guard: the bytes of a GNSS receiver that sends all the time, and the frames of
//! a full bus.

use super::inputs::Random;
use core::fmt::Write;
use heapless::{String, Vec};
use tautrack::bus::network::function;
use tautrack::can::Frame;

/// Bytes of the receiver in one tick; 115200 baud bring 12.
pub const BYTES: usize = 16;
/// Frames of eight bytes that a bus at 1 Mbit/s can carry in one tick.
pub const FRAMES: usize = 8;

/// What a guard receives besides what it needs.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Traffic {
    /// No GNSS receiver, and only the frames of the drives.
    Quiet,
    /// A GNSS receiver that sends GGA and RMC sentences without a pause, and as many frames of
    /// other nodes as the bus can carry.
    Busy,
}

/// Source of the traffic.
pub struct Source {
    traffic: Traffic,
    random: Random,
    text: String<192>,
    sent: usize,
    fixes: u32,
}

impl Source {
    /// Creates a source at the start of its sequence.
    pub fn new(traffic: Traffic) -> Self {
        Self {
            traffic,
            random: Random::new(),
            text: String::new(),
            sent: 0,
            fixes: 0,
        }
    }

    /// Returns the receiver's bytes of the next tick.
    pub fn bytes(&mut self) -> Vec<u8, BYTES> {
        let mut bytes = Vec::new();
        while self.traffic == Traffic::Busy && bytes.len() < BYTES {
            if self.sent == self.text.len() {
                self.next_fix();
            }
            let byte = self.text.as_bytes().get(self.sent).copied();
            // There is room for it.
            let _ = bytes.push(byte.unwrap_or_default());
            self.sent += 1;
        }
        bytes
    }

    /// Writes both sentences of the next fix; the time and the last digits of the place change.
    fn next_fix(&mut self) {
        self.text.clear();
        self.sent = 0;
        self.fixes += 1;
        let (second, hundredth) = (self.fixes / 5 % 60, self.fixes % 5 * 20);
        let noise = self.random.bits() as u32 % 100;
        let mut body = String::<96>::new();
        // There is room for both sentences.
        let _ = write!(
            body,
            "GPGGA,1200{second:02}.{hundredth:02},4728.704{noise:02},N,00033.792{noise:02},W,\
             4,12,0.80,40.{noise:02}3,M,48.000,M,1.0,0000"
        );
        self.end_sentence(&body);
        body.clear();
        let _ = write!(
            body,
            "GPRMC,1200{second:02}.{hundredth:02},A,4728.704{noise:02},N,00033.792{noise:02},W,\
             0.5{noise:02},123.{noise:02},231126,0.5,W,R"
        );
        self.end_sentence(&body);
    }

    fn end_sentence(&mut self, body: &str) {
        let checksum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        let _ = write!(self.text, "${body}*{checksum:02X}\r\n");
    }

    /// Returns the frames of other nodes in the next tick of a robot whose guard and drives have
    /// the node ids `guard` and `drives`.
    pub fn frames(&mut self, guard: u8, drives: &[u8]) -> Vec<Frame, FRAMES> {
        /// Answers of a drive to a client, and process data that the guard does not use.
        const OF_A_DRIVE: [u16; 3] = [0x580, function::TPDO[2], function::TPDO[3]];
        /// Everything that another robot on the same bus sends.
        const OF_OTHERS: [u16; 8] = [
            function::SYNC_OR_EMERGENCY,
            function::TPDO[0],
            function::TPDO[1],
            function::TPDO[2],
            function::RPDO[0],
            0x580,
            0x600,
            function::HEARTBEAT,
        ];
        let mut frames = Vec::new();
        while self.traffic == Traffic::Busy && !frames.is_full() {
            let bits = self.random.bits() as u32;
            let node = (bits >> 8 & 0x7f) as u8;
            let function = if drives.contains(&node) {
                OF_A_DRIVE[bits as usize % OF_A_DRIVE.len()]
            } else if node == guard || node == 0 {
                continue;
            } else {
                OF_OTHERS[bits as usize % OF_OTHERS.len()]
            };
            let data = [self.random.bits(), self.random.bits()].map(i32::to_le_bytes);
            let frame = Frame::new(function + u16::from(node), data.as_flattened());
            let _ = frames.push(frame.unwrap_or_default()); // the loop ends when it is full
        }
        frames
    }
}
