//! Carries messages between a [`Machine`] and a byte pipe.

use super::flash::Files;
use super::machine::{End, Machine};
use crate::roles::Role;
use tautrack::link::MAX_MESSAGE;

/// Bytes of the length in front of each message.
const PREFIX: usize = 2;

/// Byte pipe to and from the simulator.
pub trait Pipe {
    /// Reads what has arrived, at most as much as `buffer` holds; waits for the first byte. Returns
    /// the number of bytes, 0 if the simulator has closed the pipe.
    fn read(&mut self, buffer: &mut [u8]) -> usize;
    /// Writes all of `bytes`. Returns `false` if the simulator has closed the pipe.
    fn write(&mut self, bytes: &[u8]) -> bool;
}

/// Answers the messages of `pipe` until the node ends. The flash may be in one of `files`.
pub fn run(board: &'static str, role: &'static Role, files: Files, pipe: &mut impl Pipe) -> End {
    let mut machine = Machine::new(board, role, Some(files));
    let mut buffer = [0; PREFIX + MAX_MESSAGE];
    while let Some(length) = receive(pipe, &mut buffer) {
        let (prefix, body) = buffer.split_at_mut(PREFIX);
        let length = match machine.answer(body, length) {
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

/// Receives one message with its prefix, mostly in one read. The simulator waits for the answer
/// before it sends the next. Returns the length without the prefix, `None` if the pipe is closed or
/// what it brings is no such message.
fn receive(pipe: &mut impl Pipe, buffer: &mut [u8]) -> Option<usize> {
    let (mut have, mut whole) = (0, PREFIX);
    while have < whole {
        let read = pipe.read(buffer.get_mut(have..)?);
        have += Some(read).filter(|read| *read > 0)?;
        if have >= PREFIX {
            whole = PREFIX + usize::from(u16::from_le_bytes([buffer[0], buffer[1]]));
        }
    }
    (have == whole).then_some(whole - PREFIX)
}
