//! Connection to an SLCAN adapter: a serial device, or a TCP address.

use super::error::ToolError;
use crate::simulator::slcan::{Request, line_of};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::os::fd::AsFd;
use std::time::Instant;
use tautrack::can::Frame;

/// Closes the channel, sets 1 Mbit/s, and opens it.
const OPEN: &[u8] = b"C\rS8\rO\r";
/// Time for which a read waits before the deadline is checked.
const POLL: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: 10_000_000,
};
/// Rate of a serial line. An adapter on USB ignores it.
const BITS_PER_SECOND: u32 = 115_200;

pub(super) struct Adapter {
    address: String,
    stream: Box<dyn Stream>,
    incoming: Vec<u8>,
}

trait Stream: Read + Write + AsFd {}

impl<T: Read + Write + AsFd> Stream for T {}

impl Adapter {
    /// Connects and opens the channel. `address` is that of TCP, or the path of a device if it
    /// begins with `/`.
    pub fn open(address: &str) -> Result<Self, ToolError> {
        let fail = |error| ToolError::Adapter(address.to_owned(), error);
        let mut stream: Box<dyn Stream> = if address.starts_with('/') {
            Box::new(device(address).map_err(fail)?)
        } else {
            let stream = TcpStream::connect(address).map_err(fail)?;
            stream.set_nodelay(true).map_err(fail)?;
            Box::new(stream)
        };
        stream.write_all(OPEN).map_err(fail)?;
        Ok(Self {
            address: address.to_owned(),
            stream,
            incoming: Vec::new(),
        })
    }

    pub fn send(&mut self, frame: &Frame) -> Result<(), ToolError> {
        let sent = self.stream.write_all(line_of(frame, None).as_bytes());
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
                if let Request::Transmit(frame) = Request::parse(&line) {
                    return Ok(Some(frame));
                }
            }
            if Instant::now() >= deadline {
                return Ok(None);
            }
            self.read()
                .map_err(|error| ToolError::Adapter(self.address.clone(), error))?;
        }
    }

    /// Reads what comes within [`POLL`].
    fn read(&mut self) -> io::Result<()> {
        let mut readable = [PollFd::new(&self.stream, PollFlags::IN)];
        match poll(&mut readable, Some(&POLL)) {
            Ok(0) | Err(Errno::INTR) => return Ok(()),
            Ok(_) => {}
            Err(error) => return Err(error.into()),
        }
        let mut bytes = [0; 4_096];
        let count = self.stream.read(&mut bytes)?;
        if count == 0 {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        self.incoming.extend(&bytes[..count]);
        Ok(())
    }
}

/// Opens a serial device that passes every byte as it is.
fn device(path: &str) -> io::Result<File> {
    let device = rustix::fs::open(path, OFlags::RDWR | OFlags::NOCTTY, Mode::empty())?;
    let mut line = tcgetattr(&device)?;
    line.make_raw();
    line.set_speed(BITS_PER_SECOND)?;
    tcsetattr(&device, OptionalActions::Now, &line)?;
    Ok(device.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    use std::time::Duration;

    /// The other end of the line is an adapter that sends one frame. A line that is not raw would
    /// change its carriage return to a line feed, and would send the commands back.
    #[test]
    fn an_adapter_at_a_serial_device_is_opened_and_read() {
        let other = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
        grantpt(&other).expect("granted");
        unlockpt(&other).expect("unlocked");
        let path = ptsname(&other, Vec::new()).expect("a path");
        let mut other = File::from(other);
        let mut adapter = Adapter::open(path.to_str().expect("a text")).expect("it opens");
        let mut commands = [0; OPEN.len()];
        other.read_exact(&mut commands).expect("commands");
        assert_eq!(commands, OPEN);
        other.write_all(b"\rt7022AB05\r").expect("written");
        let deadline = Instant::now() + Duration::from_secs(10);
        let frame = adapter.receive(deadline).expect("no error");
        let frame = frame.expect("a frame");
        assert_eq!((frame.id(), frame.data()), (0x702, &[0xab, 0x05][..]));
    }

    #[test]
    fn what_is_no_serial_device_is_refused_with_its_name() {
        for path in ["/dev/null", "/does/not/exist"] {
            let Err(error) = Adapter::open(path) else {
                panic!("{path} was opened");
            };
            assert!(error.to_string().contains(path), "{error}");
        }
    }
}
