//! A TCP port that speaks SLCAN, so that a CAN client from elsewhere is one more participant of the virtual bus.
//!
//! SLCAN is the line protocol of serial CAN adapters (LAWICEL CAN232 manual): `t1232AABB\r` is a frame with identifier
//! 0x123 and two bytes. Clients that take a serial port's URL connect to `socket://host:port`. Any bit rate is accepted
//! and means nothing; extended and remote frames are refused, for the virtual bus carries neither.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use tautrack::can::Frame;

/// Bytes that a client may leave unread before it is taken for dead.
const MAX_UNREAD: usize = 1 << 18;
/// Longest line of the protocol: `T`, eight digits of identifier, one of length, 16 of data.
const MAX_LINE: usize = 26;
const OK: &[u8] = b"\r";
const REFUSED: &[u8] = b"\x07";

/// What one line of a client asks for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Request {
    /// `t`: send a frame.
    Transmit(Frame),
    /// `O`: take part in the bus.
    Open,
    /// `C`: leave the bus.
    Close,
    /// `S0` to `S8`: set the bit rate.
    BitRate,
    /// `V`: hardware and software version.
    Version,
    /// `N`: serial number.
    SerialNumber,
    /// `F`: status flags.
    Status,
    /// Anything else, extended and remote frames included.
    Unsupported,
}

impl Request {
    /// Reads one line without its carriage return. An empty line, which clients send to synchronise, is none.
    pub fn parse(line: &[u8]) -> Option<Self> {
        let (command, argument) = line.split_first()?;
        Some(match (command, argument) {
            (b't', frame) => parse_frame(frame).map_or(Self::Unsupported, Self::Transmit),
            (b'O', []) => Self::Open,
            (b'C', []) => Self::Close,
            (b'S', [b'0'..=b'8']) => Self::BitRate,
            (b'V', []) => Self::Version,
            (b'N', []) => Self::SerialNumber,
            (b'F', []) => Self::Status,
            _ => Self::Unsupported,
        })
    }
}

fn parse_frame(text: &[u8]) -> Option<Frame> {
    let (head, data) = text.split_at_checked(4)?;
    let id = number(&head[..3])?;
    let length = number(&head[3..])?;
    if data.len() != 2 * usize::from(length) {
        return None;
    }
    let bytes: Option<Vec<u8>> = data
        .chunks(2)
        .map(|byte| number(byte).map(|byte| byte as u8))
        .collect();
    Frame::new(id, &bytes?)
}

/// A number of at most four hexadecimal digits.
fn number(digits: &[u8]) -> Option<u16> {
    digits.iter().try_fold(0, |value, digit| {
        Some(value << 4 | char::from(*digit).to_digit(16)? as u16)
    })
}

/// The line, carriage return included, with which a client is handed `frame`.
pub fn line_of(frame: &Frame) -> String {
    use std::fmt::Write;
    let mut line = format!("t{:03X}{}", frame.id(), frame.data().len());
    for byte in frame.data() {
        // Writing to a string cannot fail.
        let _ = write!(line, "{byte:02X}");
    }
    line.push('\r');
    line
}

/// The port: one client at a time, the next one when it has left. Nothing here ever waits.
#[derive(Debug)]
pub struct SlcanPort {
    listener: TcpListener,
    client: Option<Client>,
}

impl SlcanPort {
    /// Listens on `address`; port 0 takes a free one.
    ///
    /// # Errors
    /// The operating system's, when the address cannot be had.
    pub fn bind(address: impl ToSocketAddrs) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener,
            client: None,
        })
    }

    /// Where the port listens.
    ///
    /// # Errors
    /// The operating system's.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Whether a client has opened the channel.
    pub fn attached(&self) -> bool {
        self.client.as_ref().is_some_and(|client| client.open)
    }

    /// Answers the client and takes at most `room` frames from it; what it sent beyond them waits in its connection.
    pub fn poll(&mut self, room: usize) -> Vec<Frame> {
        if self.client.is_none() {
            self.client = self.accept();
        }
        let mut frames = Vec::new();
        if let Some(client) = &mut self.client
            && client.exchange(room, &mut frames).is_err()
        {
            self.client = None;
        }
        frames
    }

    /// Hands `frame` to the client, when there is one with an open channel.
    pub fn send(&mut self, frame: &Frame) {
        if let Some(client) = self.client.as_mut().filter(|client| client.open) {
            client.outgoing.extend(line_of(frame).into_bytes());
            if client.flush().is_err() {
                self.client = None;
            }
        }
    }

    /// The next client; one that cannot be had now, for whatever reason, is tried again at the next poll.
    fn accept(&self) -> Option<Client> {
        let (stream, _) = self.listener.accept().ok()?;
        stream.set_nonblocking(true).ok()?;
        // A client waits for each answer; collecting bytes into larger packets would cost it some 40 ms.
        stream.set_nodelay(true).ok()?;
        Some(Client {
            stream,
            open: false,
            incoming: Vec::new(),
            outgoing: Vec::new(),
        })
    }
}

#[derive(Debug)]
struct Client {
    stream: TcpStream,
    open: bool,
    incoming: Vec<u8>,
    outgoing: Vec<u8>,
}

impl Client {
    /// An error means that the client is gone.
    fn exchange(&mut self, room: usize, frames: &mut Vec<Frame>) -> io::Result<()> {
        loop {
            while frames.len() < room
                && let Some(end) = self.incoming.iter().position(|byte| *byte == b'\r')
            {
                let line: Vec<u8> = self.incoming.drain(..=end).collect();
                self.answer(&line[..end], frames);
            }
            if frames.len() >= room {
                break;
            }
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

    fn answer(&mut self, line: &[u8], frames: &mut Vec<Frame>) {
        let Some(request) = Request::parse(line) else {
            return;
        };
        let answer = match request {
            Request::Transmit(frame) if self.open => {
                frames.push(frame);
                b"z\r"
            }
            Request::Open => {
                self.open = true;
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

    fn flush(&mut self) -> io::Result<()> {
        while !self.outgoing.is_empty() {
            match self.stream.write(&self.outgoing) {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(count) => drop(self.outgoing.drain(..count)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        if self.outgoing.len() > MAX_UNREAD {
            return Err(ErrorKind::TimedOut.into());
        }
        Ok(())
    }
}
