//! Carries messages between a [`Machine`] and a byte pipe.

use super::machine::{End, Machine};
use tautrack::link::{MAX_MESSAGE, PREFIX, Stepped};

/// Byte pipe to and from the simulator.
pub trait Pipe {
    /// Reads what has arrived, at most as much as `buffer` holds; waits for the first byte. Returns
    /// the number of bytes, 0 if the simulator has closed the pipe.
    fn read(&mut self, buffer: &mut [u8]) -> usize;
    /// Writes all of `bytes`. Returns `false` if the simulator has closed the pipe.
    fn write(&mut self, bytes: &[u8]) -> bool;
}

/// Answers the messages of `pipe` until the simulator or the node ends.
pub fn run(mut machine: Machine, pipe: &mut impl Pipe) -> End {
    let mut inbox = Inbox::new();
    let mut buffer = [0; PREFIX + MAX_MESSAGE];
    let mut stepped = Stepped::default();
    while let Some(length) = inbox.receive(pipe, &mut buffer) {
        let (prefix, body) = buffer.split_at_mut(PREFIX);
        let length = match machine.answer(body, length, &mut stepped) {
            Ok(length) => length,
            Err(end) => return end,
        };
        prefix.copy_from_slice(&(length as u16).to_le_bytes());
        // One write for prefix and message, because each costs a trap into the emulator.
        if !pipe.write(&buffer[..PREFIX + length]) {
            break;
        }
    }
    End::Finished
}

/// Bytes of the pipe that are not answered yet: at most one message.
struct Inbox {
    bytes: [u8; PREFIX + MAX_MESSAGE],
    have: usize,
}

impl Inbox {
    const fn new() -> Self {
        Self {
            bytes: [0; PREFIX + MAX_MESSAGE],
            have: 0,
        }
    }

    /// Moves the next message with its prefix to `buffer`. Reads the pipe only if the message is
    /// not here, and then all that has arrived. Returns the message's length, `None` if the pipe is
    /// closed or what it brings is no such message.
    fn receive(&mut self, pipe: &mut impl Pipe, buffer: &mut [u8]) -> Option<usize> {
        loop {
            let length = usize::from(u16::from_le_bytes(*self.bytes.first_chunk()?));
            let whole = PREFIX + length;
            if self.have >= PREFIX && self.have >= whole {
                buffer
                    .get_mut(..whole)?
                    .copy_from_slice(&self.bytes[..whole]);
                self.bytes.copy_within(whole..self.have, 0);
                self.have -= whole;
                return Some(length);
            }
            let read = pipe.read(self.bytes.get_mut(self.have..)?);
            self.have += Some(read).filter(|read| *read > 0)?;
        }
    }
}
