//! Ctrl-C ends a run in good order, and the second Ctrl-C ends the program at once.

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Exit status of a run that the user interrupted: that of a program which SIGINT ends.
pub const STATUS: u8 = 128 + SIGINT as u8;

/// From now on SIGINT and SIGTERM set the returned flag. If it is set already, they end the
/// program.
///
/// # Errors
/// The operating system's.
pub fn flag() -> io::Result<Arc<AtomicBool>> {
    let interrupted = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // In this order: the first looks at the flag before the second sets it.
        let status = i32::from(STATUS);
        flag::register_conditional_shutdown(signal, status, Arc::clone(&interrupted))?;
        flag::register(signal, Arc::clone(&interrupted))?;
    }
    Ok(interrupted)
}
