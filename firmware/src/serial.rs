//! Serial line of the board, to which a GNSS receiver may be connected.

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::pipe::Pipe;

/// Received bytes for the guard's control task; holds 20 ms at 115200 baud.
static RECEIVED: Pipe<CriticalSectionRawMutex, 256> = Pipe::new();

/// Keeps received bytes. Those that do not fit are lost; the checksum of their sentence then fails.
pub fn put(mut bytes: &[u8]) {
    // The pipe takes at one time what fits before the end of its memory.
    while let Ok(count) = RECEIVED.try_write(bytes)
        && count > 0
    {
        bytes = bytes.get(count..).unwrap_or_default();
    }
}

/// Takes the oldest bytes, as many as `bytes` has room for. Returns their number.
pub fn take(bytes: &mut [u8]) -> usize {
    let mut taken = 0;
    while let Some(rest) = bytes.get_mut(taken..)
        && let Ok(count) = RECEIVED.try_read(rest)
        && count > 0
    {
        taken += count;
    }
    taken
}
