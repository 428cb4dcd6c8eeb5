//! Connection of an SLCAN client: reads its lines and writes answers and frames.

use super::Request;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tautrack::can::Frame;

/// Maximum length of a line of the protocol: `T`, eight digits of identifier, one of length, 16 of
/// data.
const MAX_LINE: usize = 26;
/// Maximum number of bytes that are read from the connection before the lines in them are answered.
const MAX_UNANSWERED: usize = 4096;
const OK: &[u8] = b"\r";
const REFUSED: &[u8] = b"\x07";

/// Connected client.
#[derive(Debug)]
pub struct Client {
    stream: TcpStream,
    open: bool,
    joined: bool,
    incoming: Vec<u8>,
    outgoing: VecDeque<u8>,
    /// Time at which the connection last accepted bytes, or had none to accept.
    read_at: Instant,
}

impl Client {
    /// Creates a client whose channel is closed.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn new(stream: TcpStream) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        // A client waits for each answer. Collecting bytes into larger packets would delay it by
        // some 40 ms.
        stream.set_nodelay(true)?;
        Ok(Self {
            stream,
            open: false,
            joined: false,
            incoming: Vec::new(),
            outgoing: VecDeque::new(),
            read_at: Instant::now(),
        })
    }

    /// Whether the channel is open.
    pub fn open(&self) -> bool {
        self.open
    }

    /// Whether the channel is open, or was open before.
    pub fn has_joined(&self) -> bool {
        self.joined
    }

    /// Number of bytes that the connection has not accepted yet.
    pub fn unsent(&self) -> usize {
        self.outgoing.len()
    }

    /// Time for which the connection has accepted none of the waiting bytes.
    pub fn silent_for(&self) -> Duration {
        self.read_at.elapsed()
    }

    /// Answers the client's lines and appends at most `room` of its frames to `frames`. Any further
    /// frame, and all lines after it, wait.
    ///
    /// # Errors
    /// If the client has disconnected.
    pub fn exchange(&mut self, room: usize, frames: &mut Vec<Frame>) -> io::Result<()> {
        while self.answer_lines(room, frames) && self.incoming.len() < MAX_UNANSWERED {
            if self.incoming.len() > MAX_LINE {
                self.incoming.clear();
                self.outgoing.extend(REFUSED);
            }
            let mut chunk = [0; 512];
            match self.stream.read(&mut chunk) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(count) => self.incoming.extend(&chunk[..count]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        self.flush()
    }

    /// Sends `bytes`, as many as the connection accepts now; the rest waits.
    ///
    /// # Errors
    /// If the client has disconnected.
    pub fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.outgoing.extend(bytes);
        self.flush()
    }

    /// Sends the waiting bytes, as many as the connection accepts now.
    ///
    /// # Errors
    /// If the client has disconnected.
    pub fn flush(&mut self) -> io::Result<()> {
        while !self.outgoing.is_empty() {
            match self.stream.write(self.outgoing.as_slices().0) {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(count) => {
                    self.outgoing.drain(..count);
                    self.read_at = Instant::now();
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(()),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        self.read_at = Instant::now();
        Ok(())
    }

    /// Answers all complete lines. Returns `false` if there was no room for a frame.
    fn answer_lines(&mut self, room: usize, frames: &mut Vec<Frame>) -> bool {
        while let Some(end) = self.incoming.iter().position(|byte| *byte == b'\r') {
            let request = Request::parse(&self.incoming[..end]);
            let transmits = self.open && matches!(request, Some(Request::Transmit(_)));
            if transmits && frames.len() >= room {
                return false;
            }
            self.incoming.drain(..=end);
            if let Some(request) = request {
                self.answer(request, frames);
            }
        }
        true
    }

    fn answer(&mut self, request: Request, frames: &mut Vec<Frame>) {
        let answer = match request {
            Request::Transmit(frame) if self.open => {
                frames.push(frame);
                b"z\r"
            }
            Request::Open => {
                self.open = true;
                self.joined = true;
                OK
            }
            Request::Close => {
                self.open = false;
                OK
            }
            Request::BitRate => OK,
            Request::Version => b"V0101\r",
            Request::SerialNumber => b"N0001\r",
            Request::Status => b"F00\r",
            Request::Transmit(_) | Request::Unsupported => REFUSED,
        };
        self.outgoing.extend(answer);
    }
}
