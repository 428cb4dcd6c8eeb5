//! What an adapter does with its client's lines and with the frames of the bus. This is the
//! protocol without the connection.

use super::protocol::{MAX_LINE, Request, line_of};
use std::collections::VecDeque;
use tautrack::can::Frame;

const OK: &[u8] = b"\r";
const REFUSED: &[u8] = b"\x07";
/// A time stamp counts the milliseconds of a minute.
const MINUTE_MS: u64 = 60_000;

#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
enum Mode {
    #[default]
    Closed,
    ListenOnly,
    Normal,
}

/// Channel of one client, closed at first.
#[derive(Debug, Default)]
pub struct Channel {
    mode: Mode,
    joined: bool,
    time_stamps: bool,
    /// Bytes that are not answered yet.
    incoming: Vec<u8>,
}

impl Channel {
    /// Whether the channel is open: whether frames of the bus reach the client.
    pub fn is_open(&self) -> bool {
        self.mode != Mode::Closed
    }

    /// Whether the channel is open, or was open before.
    pub fn has_joined(&self) -> bool {
        self.joined
    }

    /// Adds bytes of the client. [`Self::answer`] must have returned `true` since the last call.
    pub fn receive(&mut self, bytes: &[u8]) {
        self.incoming.extend(bytes);
    }

    /// Appends one answer to `answers` for each complete line, and the client's frames to `frames`
    /// until it has `room`. Returns `false` if there is no room for a further frame; it waits, and
    /// so do all lines after it.
    pub fn answer(
        &mut self,
        room: usize,
        frames: &mut Vec<Frame>,
        answers: &mut VecDeque<u8>,
    ) -> bool {
        while let Some(end) = self.incoming.iter().position(|byte| *byte == b'\r') {
            let request = Request::parse(&self.incoming[..end]);
            let transmits = self.mode == Mode::Normal && matches!(request, Request::Transmit(_));
            if transmits && frames.len() >= room {
                return false;
            }
            self.incoming.drain(..=end);
            answers.extend(self.answer_to(request, frames));
        }
        // A line that is too long stays too long, so the rest of it is not needed.
        self.incoming.truncate(MAX_LINE + 1);
        true
    }

    fn answer_to(&mut self, request: Request, frames: &mut Vec<Frame>) -> &'static [u8] {
        match (request, self.mode) {
            (Request::Transmit(frame), Mode::Normal) => {
                frames.push(frame);
                b"z\r"
            }
            (Request::TransmitUnheard { extended: false }, Mode::Normal) => b"z\r",
            (Request::TransmitUnheard { extended: true }, Mode::Normal) => b"Z\r",
            (Request::Open, Mode::Closed) => self.open(Mode::Normal),
            (Request::Listen, Mode::Closed) => self.open(Mode::ListenOnly),
            (Request::Close, Mode::Normal | Mode::ListenOnly) => {
                self.mode = Mode::Closed;
                OK
            }
            (Request::Confirm, Mode::Closed) => OK,
            (Request::TimeStamps(on), Mode::Closed) => {
                self.time_stamps = on;
                OK
            }
            (Request::Version, _) => b"V0101\r",
            (Request::SerialNumber, _) => b"N0001\r",
            (Request::Status, Mode::Normal | Mode::ListenOnly) => b"F00\r",
            _ => REFUSED,
        }
    }

    fn open(&mut self, mode: Mode) -> &'static [u8] {
        self.mode = mode;
        self.joined = true;
        OK
    }

    /// Formats the line for a frame that the client receives at `time_us`; `None` while the channel
    /// is closed.
    pub fn line_of(&self, frame: &Frame, time_us: u64) -> Option<String> {
        let stamp = (time_us / 1_000 % MINUTE_MS) as u16;
        self.is_open()
            .then(|| line_of(frame, self.time_stamps.then_some(stamp)))
    }
}
