//! Measures the deepest stack use. At start the stack is filled with a pattern ("painted"); words
//! that still hold the pattern at the end were never used.

use core::ptr::{read_volatile, write_volatile};
use cortex_m::register::msp;

/// Fill pattern, which a program is unlikely to write by chance.
const PAINT: u32 = 0x5ac3_3ca5;
/// Bytes below the top of the stack that are painted. A deeper stack use reads as this value.
const DEPTH: usize = 64 * 1024;
/// Bytes left unpainted for the stack frame of [`paint`] itself.
const OWN: usize = 256;

unsafe extern "C" {
    /// Top of the stack, from the link script.
    static _stack_start: u32;
}

fn bottom() -> usize {
    (&raw const _stack_start as usize) - DEPTH
}

/// Paints the stack below the caller. Must be called once, before anything else.
#[inline(never)]
pub fn paint() {
    let end = msp::read() as usize - OWN;
    for address in (bottom()..end).step_by(4) {
        // SAFETY: the address is in RAM above all static variables (4 MB, of which they take some
        // kilobytes) and below every stack frame in use.
        unsafe { write_volatile(address as *mut u32, PAINT) };
    }
}

/// Returns the maximum number of bytes of stack that were in use since [`paint`].
pub fn used() -> usize {
    let mut address = bottom();
    // SAFETY: the same memory as in [`paint`]; reading changes nothing.
    while address < bottom() + DEPTH && unsafe { read_volatile(address as *const u32) } == PAINT {
        address += 4;
    }
    bottom() + DEPTH - address
}
