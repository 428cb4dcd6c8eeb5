//! How deep the stack has been: it is painted at start, and what is still painted at the end was never used.

use core::ptr::{read_volatile, write_volatile};
use cortex_m::register::msp;

/// A pattern that no program leaves behind by chance.
const PAINT: u32 = 0x5ac3_3ca5;
/// Bytes below the top of the stack that are painted; a deeper stack reads as this.
const DEPTH: usize = 64 * 1024;
/// Room for this function's own calls, bytes.
const OWN: usize = 256;

unsafe extern "C" {
    /// The top, from the link script.
    static _stack_start: u32;
}

fn bottom() -> usize {
    (&raw const _stack_start as usize) - DEPTH
}

/// Paints everything below the caller; once, before anything else.
#[inline(never)]
pub fn paint() {
    let end = msp::read() as usize - OWN;
    for address in (bottom()..end).step_by(4) {
        // SAFETY: RAM above all static variables (4 MB, of which they take some kilobytes) and below every frame in use.
        unsafe { write_volatile(address as *mut u32, PAINT) };
    }
}

/// Most bytes of stack that were in use since [`paint`].
pub fn used() -> usize {
    let mut address = bottom();
    // SAFETY: as above; reading changes nothing.
    while address < bottom() + DEPTH && unsafe { read_volatile(address as *const u32) } == PAINT {
        address += 4;
    }
    bottom() + DEPTH - address
}
