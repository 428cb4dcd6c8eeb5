//! A TCP port that speaks SLCAN. Each CAN client that connects is one more participant of the
//! virtual bus.
//!
//! SLCAN is the line protocol of serial CAN adapters (LAWICEL CAN232 manual): `t1232AABB\r` is a
//! frame with identifier 0x123 and two bytes. Clients that take a serial port's URL connect to
//! `socket://host:port`. Any bit rate is accepted and has no effect. Extended and remote frames are
//! refused, because the virtual bus carries neither.
//!
//! [`Request`] is the protocol, [`SlcanPort`] the port, `client` one connection.

mod client;

use client::Client;
use rustix::net::sockopt::set_socket_send_buffer_size;
use std::io;
use std::net::{SocketAddr, TcpListener, ToSocketAddrs};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tautrack::can::Frame;

/// Clients that can take part at once. One more is disconnected at once.
pub const MAX_CLIENTS: usize = 8;

/// Unsent bytes that the system keeps per client. More would be frames that a slow client receives
/// long after they were sent.
const SEND_BUFFER: usize = 4096;
/// Unsent bytes of a client for which the run waits: a tenth of a second of a busy bus.
const BACKLOG: usize = 8192;
/// A client that reads nothing for so long, while the run waits for it, is disconnected.
const READ_TIMEOUT: Duration = Duration::from_secs(5);
/// Time between two looks at a connection for which something waits.
const POLL_INTERVAL: Duration = Duration::from_millis(1);

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

/// Empties the place of a client. One that never opened its channel was none.
fn leave(number: usize, place: &mut Option<Client>) {
    if place.take().is_some_and(|client| client.has_joined()) {
        eprintln!("tautrack: CAN client {} leaves", number + 1);
    }
}

/// The line, carriage return included, that carries `frame` to a client.
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

/// The port: up to [`MAX_CLIENTS`] clients, each with a number below that.
#[derive(Debug)]
pub struct SlcanPort {
    listener: TcpListener,
    clients: [Option<Client>; MAX_CLIENTS],
    joined: usize,
}

impl SlcanPort {
    /// Listens on `address`; port 0 takes a free one.
    ///
    /// # Errors
    /// The operating system's, if the address is none or is in use.
    pub fn bind(address: impl ToSocketAddrs) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        // The connections inherit it.
        set_socket_send_buffer_size(&listener, SEND_BUFFER)?;
        Ok(Self {
            listener,
            clients: [const { None }; MAX_CLIENTS],
            joined: 0,
        })
    }

    /// Where the port listens.
    ///
    /// # Errors
    /// The operating system's.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Number of clients whose channel is open.
    pub fn attached(&self) -> usize {
        self.clients
            .iter()
            .flatten()
            .filter(|client| client.open())
            .count()
    }

    /// Number of connections that have opened the channel since the port was made.
    pub fn joined(&self) -> usize {
        self.joined
    }

    /// Waits until a client has opened the channel, for at most `timeout` (without limit if
    /// absent), or until `stop` holds; whether one has. What the client sends after that waits in
    /// its connection.
    pub fn wait_for_client(&mut self, timeout: Option<Duration>, stop: &dyn Fn() -> bool) -> bool {
        let began = Instant::now();
        loop {
            self.poll(|_| 0);
            if self.attached() > 0 {
                return true;
            }
            if timeout.is_some_and(|timeout| began.elapsed() >= timeout) || stop() {
                return false;
            }
            sleep(POLL_INTERVAL);
        }
    }

    /// Answers the clients and takes at most `room(number)` frames from each; each frame comes with
    /// its client's number. What a client sends beyond that waits in its connection. Does not wait.
    pub fn poll(&mut self, room: impl Fn(usize) -> usize) -> Vec<(usize, Frame)> {
        self.accept();
        let mut frames = Vec::new();
        for (number, place) in self.clients.iter_mut().enumerate() {
            let Some(client) = place else { continue };
            let before = client.has_joined();
            let mut taken = Vec::new();
            let gone = client.exchange(room(number), &mut taken).is_err();
            if client.has_joined() && !before {
                self.joined += 1;
                eprintln!("tautrack: CAN client {} joins", number + 1);
            }
            frames.extend(taken.into_iter().map(|frame| (number, frame)));
            if gone {
                leave(number, place);
            }
        }
        frames
    }

    /// Sends `frame` to every client with an open channel but `sender`, the number of the client
    /// that it comes from. Does not wait.
    pub fn send(&mut self, frame: &Frame, sender: Option<usize>) {
        let line = line_of(frame);
        for (number, place) in self.clients.iter_mut().enumerate() {
            let listens = |client: &&mut Client| client.open() && sender != Some(number);
            let gone = place
                .as_mut()
                .filter(listens)
                .is_some_and(|client| client.send(line.as_bytes()).is_err());
            if gone {
                leave(number, place);
            }
        }
    }

    /// Waits until every client has read its frames up to a tenth of a second's worth. A client
    /// that reads nothing for five seconds is disconnected, and standard error says so.
    pub fn wait_for_readers(&mut self) {
        loop {
            let mut waiting = false;
            for (number, place) in self.clients.iter_mut().enumerate() {
                let Some(client) = place else { continue };
                if client.unsent() <= BACKLOG {
                    continue;
                }
                let gone = client.flush().is_err();
                let dead = client.unsent() > BACKLOG && client.silent_for() > READ_TIMEOUT;
                if dead {
                    eprintln!(
                        "tautrack: CAN client {} reads nothing for {} s and is disconnected",
                        number + 1,
                        READ_TIMEOUT.as_secs()
                    );
                }
                if gone || dead {
                    leave(number, place);
                } else {
                    waiting |= client.unsent() > BACKLOG;
                }
            }
            if !waiting {
                return;
            }
            sleep(POLL_INTERVAL);
        }
    }

    /// Takes the connections that are waiting. One that fails now, for whatever reason, is tried
    /// again at the next poll; one for which there is no place is closed.
    fn accept(&mut self) {
        while let Ok((stream, _)) = self.listener.accept() {
            let free = self.clients.iter_mut().find(|place| place.is_none());
            match (free, Client::new(stream)) {
                (Some(place), Ok(client)) => *place = Some(client),
                (None, _) => {
                    eprintln!(
                        "tautrack: a CAN client is refused: {MAX_CLIENTS} have joined already"
                    );
                }
                (Some(_), Err(_)) => {}
            }
        }
    }
}
