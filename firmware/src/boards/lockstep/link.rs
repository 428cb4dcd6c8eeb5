//! Sends and receives whole messages over a byte pipe.

use tautrack::link::{FromNode, MAX_MESSAGE, ToNode};

/// Byte pipe to and from the simulator.
pub trait Pipe {
    /// Fills `buffer`; blocks as long as needed. Returns `false` if the simulator has closed the
    /// pipe.
    fn read(&mut self, buffer: &mut [u8]) -> bool;
    /// Writes all of `bytes`. Returns `false` if the simulator has closed the pipe.
    fn write(&mut self, bytes: &[u8]) -> bool;
}

/// Sends and receives whole messages over a [`Pipe`]. A message has a length prefix of two bytes.
pub(super) struct Link<'a, P> {
    pub pipe: &'a mut P,
    pub buffer: [u8; MAX_MESSAGE + 2],
}

impl<P: Pipe> Link<'_, P> {
    pub fn receive(&mut self) -> Option<ToNode> {
        let mut length = [0; 2];
        if !self.pipe.read(&mut length) {
            return None;
        }
        let message = self
            .buffer
            .get_mut(..usize::from(u16::from_le_bytes(length)))?;
        if !self.pipe.read(message) {
            return None;
        }
        postcard::from_bytes(message).ok()
    }

    /// Sends `message`. Writes prefix and message at once, because each write costs a trap into the
    /// emulator.
    pub fn send(&mut self, message: &FromNode) -> bool {
        let Some(body) = self.buffer.get_mut(2..) else {
            return false;
        };
        let Ok(length) = postcard::to_slice(message, body).map(|used| used.len()) else {
            return false;
        };
        self.buffer[..2].copy_from_slice(&(length as u16).to_le_bytes());
        self.pipe.write(&self.buffer[..length + 2])
    }
}
