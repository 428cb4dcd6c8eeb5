//! Bytes that come in on the board's serial line, where a GNSS receiver may sit.

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::pipe::Pipe;

/// Bytes on their way from the board to the guard's control task: 20 ms at 115200 baud. What comes while it is full is lost,
/// and the checksum of its sentence tells.
pub static RECEIVED: Pipe<CriticalSectionRawMutex, 256> = Pipe::new();
