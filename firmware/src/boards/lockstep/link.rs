//! Carries messages between a [`Machine`] and a byte pipe.

use super::flash::Files;
use super::machine::{End, Machine};
use crate::roles::Role;
use tautrack::link::MAX_MESSAGE;

/// Bytes of the length in front of each message.
const PREFIX: usize = 2;

/// Byte pipe to and from the simulator.
pub trait Pipe {
    /// Fills `buffer`; blocks as long as needed. Returns `false` if the simulator has closed the
    /// pipe.
    fn read(&mut self, buffer: &mut [u8]) -> bool;
    /// Writes all of `bytes`. Returns `false` if the simulator has closed the pipe.
    fn write(&mut self, bytes: &[u8]) -> bool;
}

/// Answers the messages of `pipe` until the node ends. The flash may be in one of `files`.
pub fn run(board: &'static str, role: &'static Role, files: Files, pipe: &mut impl Pipe) -> End {
    let mut machine = Machine::new(board, role, Some(files));
    let mut buffer = [0; PREFIX + MAX_MESSAGE];
    loop {
        let (prefix, body) = buffer.split_at_mut(PREFIX);
        if !pipe.read(prefix) {
            return End::Finished;
        }
        let length = usize::from(u16::from_le_bytes([prefix[0], prefix[1]]));
        let message = body.get_mut(..length);
        if !message.is_some_and(|message| pipe.read(message)) {
            return End::Finished;
        }
        let length = match machine.answer(body, length) {
            Ok(length) => length,
            Err(end) => return end,
        };
        prefix.copy_from_slice(&(length as u16).to_le_bytes());
        // One write for prefix and message, because each costs a trap into the emulator.
        if !pipe.write(&buffer[..PREFIX + length]) {
            return End::Finished;
        }
    }
}
