//! Semihosting calls: the emulator's standard streams and its exit.

use core::fmt;
use cortex_m_semihosting::{debug, nr, syscall};

/// One of the emulator's standard streams.
pub struct Stream(usize);

impl Stream {
    /// Standard input.
    pub fn standard_input() -> Option<Self> {
        Self::open(nr::open::R_BINARY)
    }

    /// Standard output.
    pub fn standard_output() -> Option<Self> {
        Self::open(nr::open::W_TRUNC_BINARY)
    }

    /// Standard error.
    pub fn standard_error() -> Option<Self> {
        Self::open(nr::open::W_APPEND_BINARY)
    }

    /// Opens the special file `:tt`, whose mode selects the stream.
    fn open(mode: usize) -> Option<Self> {
        let name = b":tt\0";
        let arguments = [name.as_ptr() as usize, mode, name.len() - 1];
        // SAFETY: the block is what SYS_OPEN reads: name, mode, length of the name.
        let handle = unsafe { syscall(nr::OPEN, &arguments) };
        (handle != usize::MAX).then_some(Self(handle))
    }

    /// Fills `buffer`; the whole emulated machine stops until the host has written enough bytes.
    /// Returns `false` at the end of the stream.
    pub fn read_exact(&self, mut buffer: &mut [u8]) -> bool {
        while !buffer.is_empty() {
            let arguments = [self.0, buffer.as_mut_ptr() as usize, buffer.len()];
            // SAFETY: the block is what SYS_READ reads: handle, address and size of memory that
            // this function may write.
            let missing = unsafe { syscall(nr::READ, &arguments) };
            if missing >= buffer.len() {
                return false;
            }
            let read = buffer.len() - missing;
            buffer = &mut buffer[read..];
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
