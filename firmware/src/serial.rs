//! Serial line of the board, to which a GNSS receiver may be connected.

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::pipe::Pipe;

/// Received bytes for the guard's control task; holds 20 ms at 115200 baud. Bytes that arrive while
/// it is full are lost; the checksum of the affected sentence then fails.
pub static RECEIVED: Pipe<CriticalSectionRawMutex, 256> = Pipe::new();
