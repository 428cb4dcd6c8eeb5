//! One connection of an SLCAN client: its lines in, its lines out.

use super::Request;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tautrack::can::Frame;

/// Longest line of the protocol: `T`, eight digits of identifier, one of length, 16 of data.
const MAX_LINE: usize = 26;
/// Bytes that are taken from the connection before the lines in them are answered.
const MAX_UNANSWERED: usize = 4096;
const OK: &[u8] = b"\r";
const REFUSED: &[u8] = b"\x07";

/// A connected client.
#[derive(Debug)]
pub struct Client {
    stream: TcpStream,
    open: bool,
    joined: bool,
    incoming: Vec<u8>,
    outgoing: VecDeque<u8>,
    /// When the connection last took bytes, or had none to take.
    read_at: Instant,
}

impl Client {
    /// A client whose channel is closed.
    ///
    /// # Errors
    /// The operating system's.
    pub fn new(stream: TcpStream) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        // A client waits for each answer; collecting bytes into larger packets would take some 40
        // ms.
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

    /// Whether the channel is open or was open before.
    pub fn has_joined(&self) -> bool {
        self.joined
    }

    /// Bytes that the connection has not taken yet.
    pub fn unsent(&self) -> usize {
        self.outgoing.len()
    }

    /// For how long the connection has taken none of the bytes that wait for it.
    pub fn silent_for(&self) -> Duration {
        self.read_at.elapsed()
    }

    /// Answers what the client sent and takes at most `room` frames. A frame beyond that, and all
    /// that follows it, waits.
    ///
    /// # Errors
    /// The client is gone.
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

    /// Sends `bytes`, as far as the connection takes them now.
    ///
    /// # Errors
    /// The client is gone.
    pub fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.outgoing.extend(bytes);
        self.flush()
    }

    /// Sends what waits, as far as the connection takes it now.
    ///
    /// # Errors
    /// The client is gone.
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

    /// Answers all whole lines; false when a frame found no room.
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
