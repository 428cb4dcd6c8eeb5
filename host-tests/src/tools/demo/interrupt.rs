//! Handles Ctrl-C: the first one ends the run and keeps its results, the second one ends the
//! program at once.

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Exit status of a run that the user interrupted: the one of a program that SIGINT ends.
pub const STATUS: u8 = 128 + SIGINT as u8;

/// Installs handlers for SIGINT and SIGTERM that set the returned flag. If the flag is already set,
/// they end the program.
///
/// # Errors
/// An error of the operating system.
pub fn flag() -> io::Result<Arc<AtomicBool>> {
    let interrupted = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // The order matters: the first handler tests the flag before the second one sets it.
        let status = i32::from(STATUS);
        flag::register_conditional_shutdown(signal, status, Arc::clone(&interrupted))?;
        flag::register(signal, Arc::clone(&interrupted))?;
    }
    Ok(interrupted)
}
