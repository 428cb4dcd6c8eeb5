//! TCP port for CAN clients, and its connected clients.

use super::client::Client;
use std::io;
use std::net::{SocketAddr, TcpListener, ToSocketAddrs};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tautrack::can::Frame;

/// Maximum number of clients at the same time. A further one is disconnected immediately.
pub const MAX_CLIENTS: usize = 8;

/// Maximum number of unsent bytes that the operating system buffers per client. With a larger
/// buffer, a slow client would receive frames long after they were sent.
#[cfg(unix)]
const SEND_BUFFER: usize = 4096;
/// Timeout for a client that reads nothing while the run waits for it; the client is then
/// disconnected.
const READ_TIMEOUT: Duration = Duration::from_secs(5);
/// Interval at which the connections are polled while the run waits.
const POLL_INTERVAL: Duration = Duration::from_millis(1);

/// Port with up to [`MAX_CLIENTS`] clients, each of which has a number below that.
#[derive(Debug)]
pub struct SlcanPort {
    listener: TcpListener,
    clients: [Option<Client>; MAX_CLIENTS],
    joined: usize,
}

impl SlcanPort {
    /// Listens on `address`; port 0 selects a free port.
    ///
    /// # Errors
    /// Those of the operating system, if the address is invalid or in use.
    pub fn bind(address: impl ToSocketAddrs) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        // The connections inherit this option. A page on the web has no port.
        #[cfg(unix)]
        rustix::net::sockopt::set_socket_send_buffer_size(&listener, SEND_BUFFER)?;
        Ok(Self {
            listener,
            clients: [const { None }; MAX_CLIENTS],
            joined: 0,
        })
    }

    /// Returns the address on which the port listens.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Number of clients whose channel is open.
    pub fn attached(&self) -> usize {
        self.clients
            .iter()
            .flatten()
            .filter(|client| client.channel().is_open())
            .count()
    }

    /// Number of connections that have opened the channel since the port was created.
    pub fn joined(&self) -> usize {
        self.joined
    }

    /// Waits until a client has opened the channel, or for at most `timeout` (unlimited if absent),
    /// or until `stop` returns `true`. Returns whether a client has opened it. What the client
    /// sends after that waits in its connection.
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

    /// Answers the clients and returns at most `room(number)` frames from each, with the client's
    /// number. Further frames of a client wait in its connection. This does not block.
    pub fn poll(&mut self, room: impl Fn(usize) -> usize) -> Vec<(usize, Frame)> {
        self.accept();
        let mut frames = Vec::new();
        for (number, place) in self.clients.iter_mut().enumerate() {
            let Some(client) = place else { continue };
            let before = client.channel().has_joined();
            let mut taken = Vec::new();
            let gone = client.exchange(room(number), &mut taken).is_err();
            if client.channel().has_joined() && !before {
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

    /// Sends `frame`, which the bus delivers at the virtual time `time_us`, to every client with an
    /// open channel, except `sender`, the number of the client that sent it. This does not block.
    pub fn send(&mut self, frame: &Frame, sender: Option<usize>, time_us: u64) {
        for (number, place) in self.clients.iter_mut().enumerate() {
            let gone = place
                .as_mut()
                .filter(|_| sender != Some(number))
                .is_some_and(|client| client.send(frame, time_us).is_err());
            if gone {
                leave(number, place);
            }
        }
    }

    /// Waits until every client has at most a tenth of a second's frames unread. A client that
    /// reads nothing for five seconds is disconnected, with a message on standard error.
    pub fn wait_for_readers(&mut self) {
        loop {
            let mut waiting = false;
            for (number, place) in self.clients.iter_mut().enumerate() {
                let Some(client) = place else { continue };
                if !client.is_behind() {
                    continue;
                }
                let gone = client.flush().is_err();
                let dead = client.is_behind() && client.silent_for() > READ_TIMEOUT;
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
                    waiting |= client.is_behind();
                }
            }
            if !waiting {
                return;
            }
            sleep(POLL_INTERVAL);
        }
    }

    /// Accepts the waiting connections. If one fails, for any reason, it is retried at the next
    /// poll; if there is no place for it, it is closed.
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

/// Removes a client. Prints a message if the client has opened its channel.
fn leave(number: usize, place: &mut Option<Client>) {
    if place
        .take()
        .is_some_and(|client| client.channel().has_joined())
    {
        eprintln!("tautrack: CAN client {} leaves", number + 1);
    }
}
