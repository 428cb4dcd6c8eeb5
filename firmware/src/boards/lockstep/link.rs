//! Carries messages between a [`Machine`] and a byte pipe.

use super::machine::{End, Machine};
use crate::roles::Role;
use static_cell::StaticCell;
use tautrack::link::{MAX_MESSAGE, Prefix, Stepped};

/// Byte pipe to and from the simulator.
pub trait Pipe {
    /// Reads what has arrived, at most as much as `buffer` holds; waits for the first byte. Returns
    /// the number of bytes, 0 if the simulator has closed the pipe.
    fn read(&mut self, buffer: &mut [u8]) -> usize;
    /// Writes all of `bytes`. Returns `false` if the simulator has closed the pipe.
    fn write(&mut self, bytes: &[u8]) -> bool;
    /// Makes all static variables those of the node with this number; those in memory belong to a
    /// node with `role`. Returns `false` if there can be no such node.
    fn turn_to(&mut self, node: u8, role: &'static Role) -> bool;
}

/// Answers the messages of `pipe` until the simulator or a node ends. Must be called only once.
///
/// Several nodes can share the pipe. Whatever belongs to a node is in static variables; the stack
/// belongs to all.
pub fn run(machine: Machine, pipe: &mut impl Pipe) -> End {
    static MACHINE: StaticCell<Machine> = StaticCell::new();
    let machine = MACHINE.init(machine);
    let mut inbox = Inbox::new();
    let mut buffer = [0; Prefix::BYTES + MAX_MESSAGE];
    let mut stepped = Stepped::default();
    while let Some(Prefix { length, node }) = inbox.receive(pipe, &mut buffer) {
        let (prefix, body) = buffer.split_at_mut(Prefix::BYTES);
        if !pipe.turn_to(node, machine.role()) {
            break;
        }
        let length = match machine.answer(body, usize::from(length), &mut stepped) {
            Ok(length) => length,
            Err(end) => return end,
        };
        let answer = Prefix {
            length: length as u16,
            node,
        };
        prefix.copy_from_slice(&answer.to_bytes());
        // One write for prefix and message, because each costs a trap into the emulator.
        if !pipe.write(&buffer[..Prefix::BYTES + length]) {
            break;
        }
    }
    End::Finished
}

/// Bytes of the pipe that are not answered yet. Of one node there is at most one message.
struct Inbox {
    bytes: [u8; Prefix::BYTES + MAX_MESSAGE],
    have: usize,
}

impl Inbox {
    const fn new() -> Self {
        Self {
            bytes: [0; Prefix::BYTES + MAX_MESSAGE],
            have: 0,
        }
    }

    /// Moves the next message with its prefix to `buffer`. Reads the pipe only if the message is
    /// not here, and then all that has arrived. Returns the prefix, `None` if the pipe is closed
    /// or what it brings is no such message.
    fn receive(&mut self, pipe: &mut impl Pipe, buffer: &mut [u8]) -> Option<Prefix> {
        loop {
            let prefix = Prefix::from_bytes(*self.bytes.first_chunk()?);
            let whole = Prefix::BYTES + usize::from(prefix.length);
            if self.have >= Prefix::BYTES && self.have >= whole {
                buffer
                    .get_mut(..whole)?
                    .copy_from_slice(&self.bytes[..whole]);
                self.bytes.copy_within(whole..self.have, 0);
                self.have -= whole;
                return Some(prefix);
            }
            let read = pipe.read(self.bytes.get_mut(self.have..)?);
            self.have += Some(read).filter(|read| *read > 0)?;
        }
    }
}
