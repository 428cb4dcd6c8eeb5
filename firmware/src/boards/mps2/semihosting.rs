//! Semihosting calls: the emulator's standard streams, the host's files, and the exit.

use core::fmt;
use cortex_m_semihosting::{debug, nr, syscall};
use tautrack::link::MAX_PATH;

/// Path of the standard streams.
const STANDARD: &str = ":tt";

/// One of the emulator's standard streams, or a file of the host.
pub struct Stream(usize);

impl Stream {
    /// Standard input.
    pub fn standard_input() -> Option<Self> {
        Self::open(STANDARD, nr::open::R_BINARY)
    }

    /// Standard output.
    pub fn standard_output() -> Option<Self> {
        Self::open(STANDARD, nr::open::W_TRUNC_BINARY)
    }

    /// Standard error.
    pub fn standard_error() -> Option<Self> {
        Self::open(STANDARD, nr::open::W_APPEND_BINARY)
    }

    /// File of the host, for reading; `None` if it does not exist.
    pub fn read_file(path: &str) -> Option<Self> {
        Self::open(path, nr::open::R_BINARY)
    }

    /// File of the host, for writing; created if it does not exist. `None` if it cannot be written.
    pub fn write_file(path: &str) -> Option<Self> {
        Self::open(path, nr::open::RW_BINARY).or_else(|| Self::open(path, nr::open::W_TRUNC_BINARY))
    }

    /// Opens a file. For [`STANDARD`], the mode selects the stream.
    fn open(path: &str, mode: usize) -> Option<Self> {
        let mut name = [0; MAX_PATH + 1]; // ends with a zero
        name.get_mut(..path.len())
            .filter(|_| path.len() <= MAX_PATH)?
            .copy_from_slice(path.as_bytes());
        let arguments = [name.as_ptr() as usize, mode, path.len()];
        // SAFETY: the block is what SYS_OPEN reads: name, mode, length of the name.
        let handle = unsafe { syscall(nr::OPEN, &arguments) };
        (handle != usize::MAX).then_some(Self(handle))
    }

    /// Closes the stream.
    pub fn close(self) {
        // SAFETY: the block is what SYS_CLOSE reads: the handle.
        unsafe { syscall(nr::CLOSE, &[self.0]) };
    }

    /// Reads at most as many bytes as `buffer` holds; the whole emulated machine stops until the
    /// host has written any. Returns their number, 0 at the end of the stream.
    pub fn read(&self, buffer: &mut [u8]) -> usize {
        let arguments = [self.0, buffer.as_mut_ptr() as usize, buffer.len()];
        // SAFETY: the block is what SYS_READ reads: handle, address and size of memory that this
        // function may write.
        let missing = unsafe { syscall(nr::READ, &arguments) };
        buffer.len().saturating_sub(missing)
    }

    /// Fills `buffer`. Returns `false` at the end of the stream.
    pub fn read_exact(&self, mut buffer: &mut [u8]) -> bool {
        while !buffer.is_empty() {
            match self.read(buffer) {
                0 => return false,
                read => buffer = &mut buffer[read..],
            }
        }
        true
    }

    /// Writes all of `bytes`. Returns `false` if the stream is closed.
    pub fn write_all(&self, mut bytes: &[u8]) -> bool {
        while !bytes.is_empty() {
            let arguments = [self.0, bytes.as_ptr() as usize, bytes.len()];
            // SAFETY: the block is what SYS_WRITE reads: handle, address and size of initialised
            // memory.
            let missing = unsafe { syscall(nr::WRITE, &arguments) };
            if missing >= bytes.len() {
                return false;
            }
            bytes = &bytes[bytes.len() - missing..];
        }
        true
    }
}

impl fmt::Write for Stream {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        if self.write_all(text.as_bytes()) {
            Ok(())
        } else {
            Err(fmt::Error)
        }
    }
}

/// Ends the emulator with exit code 0 for `success`, else 1.
pub fn exit(success: bool) -> ! {
    debug::exit(if success {
        debug::EXIT_SUCCESS
    } else {
        debug::EXIT_FAILURE
    });
    // Without an emulator the call above returns, or faults into the handler that called this
    // function.
    loop {
        cortex_m::asm::wfi();
    }
}
