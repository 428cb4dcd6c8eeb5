//! Connection to an SLCAN adapter over TCP.

use super::error::ToolError;
use crate::simulator::slcan::{Request, line_of};
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tautrack::can::Frame;

/// Closes the channel, sets 1 Mbit/s, and opens it.
const OPEN: &[u8] = b"C\rS8\rO\r";
/// Time for which a read waits before the deadline is checked.
const POLL: Duration = Duration::from_millis(10);

pub(super) struct Adapter {
    address: String,
    stream: TcpStream,
    incoming: Vec<u8>,
}

impl Adapter {
    /// Connects and opens the channel.
    pub fn open(address: &str) -> Result<Self, ToolError> {
        let fail = |error| ToolError::Adapter(address.to_owned(), error);
        let mut stream = TcpStream::connect(address).map_err(fail)?;
        stream.set_nodelay(true).map_err(fail)?;
        stream.set_read_timeout(Some(POLL)).map_err(fail)?;
        stream.write_all(OPEN).map_err(fail)?;
        Ok(Self {
            address: address.to_owned(),
            stream,
            incoming: Vec::new(),
        })
    }

    pub fn send(&mut self, frame: &Frame) -> Result<(), ToolError> {
        let sent = self.stream.write_all(line_of(frame).as_bytes());
        sent.map_err(|error| ToolError::Adapter(self.address.clone(), error))
    }

    /// Waits for the next frame; `None` if there is none until `deadline`.
    pub fn receive(&mut self, deadline: Instant) -> Result<Option<Frame>, ToolError> {
        loop {
            while let Some(end) = self.incoming.iter().position(|byte| *byte == b'\r') {
                let line: Vec<u8> = self.incoming.drain(..=end).collect();
                // Answers of the adapter itself are a carriage return or a bell.
                let line = line[..end].iter().copied().filter(|byte| *byte != 7);
                let line: Vec<u8> = line.collect();
                if let Some(Request::Transmit(frame)) = Request::parse(&line) {
                    return Ok(Some(frame));
                }
            }
            if Instant::now() >= deadline {
                return Ok(None);
            }
            let mut bytes = [0; 4_096];
            match self.stream.read(&mut bytes) {
                Ok(0) => {
                    let end = ErrorKind::UnexpectedEof.into();
                    return Err(ToolError::Adapter(self.address.clone(), end));
                }
                Ok(count) => self.incoming.extend(&bytes[..count]),
                Err(error)
                    if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                Err(error) => return Err(ToolError::Adapter(self.address.clone(), error)),
            }
        }
    }
}
