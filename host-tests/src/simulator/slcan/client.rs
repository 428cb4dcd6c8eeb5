//! Connection of an SLCAN client: reads its lines and writes answers and frames.

use super::channel::Channel;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tautrack::can::Frame;

/// Maximum number of bytes that are read at once, and maximum number of reads in one exchange, so
/// that a client that sends all the time keeps nobody waiting.
const CHUNK: usize = 512;
const READS: usize = 8;
/// Number of unsent bytes above which a client is behind: a tenth of a second of a busy bus.
const BACKLOG: usize = 8192;

/// Connected client.
#[derive(Debug)]
pub struct Client {
    stream: TcpStream,
    channel: Channel,
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
            channel: Channel::default(),
            outgoing: VecDeque::new(),
            read_at: Instant::now(),
        })
    }

    /// The client's channel.
    pub fn channel(&self) -> &Channel {
        &self.channel
    }

    /// Whether more bytes are unsent than a client leaves unread that keeps up with the bus.
    pub fn is_behind(&self) -> bool {
        self.outgoing.len() > BACKLOG
    }

    /// Time for which the connection has accepted none of the waiting bytes.
    pub fn silent_for(&self) -> Duration {
        self.read_at.elapsed()
    }

    /// Answers the client's lines and appends at most `room` of its frames to `frames`. Any further
    /// frame, and all lines after it, wait. All lines of a client that is behind wait.
    ///
    /// # Errors
    /// If the client has disconnected.
    pub fn exchange(&mut self, room: usize, frames: &mut Vec<Frame>) -> io::Result<()> {
        for _ in 0..READS {
            let all_answered = self.channel.answer(room, frames, &mut self.outgoing);
            if !all_answered || self.is_behind() {
                break;
            }
            let mut chunk = [0; CHUNK];
            match self.stream.read(&mut chunk) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(count) => self.channel.receive(&chunk[..count]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        self.flush()
    }

    /// Sends a frame of the bus, if the channel is open: as many of its bytes as the connection
    /// accepts now; the rest waits. `time_us` is the virtual time.
    ///
    /// # Errors
    /// If the client has disconnected.
    pub fn send(&mut self, frame: &Frame, time_us: u64) -> io::Result<()> {
        let Some(line) = self.channel.line_of(frame, time_us) else {
            return Ok(());
        };
        self.outgoing.extend(line.as_bytes());
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
}
