//! Guard at the end of the stack. A stack that overflows is a hard fault and overwrites nothing.
//!
//! The memory protection unit lets nobody use the first [`SIZE`] bytes behind the static variables
//! that it can guard. The handler of hard faults runs without the unit. It takes the whole stack
//! for itself if the stack has overflowed, because it never returns. If the core locks up instead,
//! this opens the bridge, and the watchdog resets the chip.

use core::arch::global_asm;
use cortex_m::peripheral::MPU;

unsafe extern "C" {
    /// End of the static variables, from the link script.
    static __euninit: u8;
}

/// Bytes of the guard, a power of two: more than the largest frame that a function leaves unused
/// between two stores.
const SIZE: usize = 512;
/// Register RASR: the region is on, has [`SIZE`] bytes, and nobody may access it.
const REGION: u32 = 1 | (SIZE.ilog2() - 1) << 1 | 1 << 28;
/// Register CTRL: the unit is on, and what no region has is as without it.
const ON: u32 = 1 | 1 << 2;

/// Sets the guard up.
pub fn start() {
    let statics = &raw const __euninit as usize;
    // SAFETY: the unit has no other user, and nothing is behind the static variables yet.
    unsafe {
        let unit = &*MPU::PTR;
        unit.rnr.write(0);
        unit.rbar.write(statics.next_multiple_of(SIZE) as u32);
        unit.rasr.write(REGION);
        unit.ctrl.write(ON);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Whether an exception whose frame begins here has found no place on the stack.
pub fn has_overflowed(frame: usize) -> bool {
    frame < &raw const __euninit as usize + MARGIN
}

/// Largest distance from the static variables to the end of the guard.
const MARGIN: usize = 2 * SIZE;

// Handler of hard faults: calls `hard_fault` with the address of the exception frame.
global_asm!(
    ".section .HardFaultTrampoline, \"ax\"",
    ".global HardFault",
    ".type HardFault, %function",
    ".thumb_func",
    "HardFault:",
    "mov r0, sp",
    "movw r1, #:lower16:__euninit",
    "movt r1, #:upper16:__euninit",
    "add.w r1, r1, #{margin}",
    "cmp r0, r1",
    "bhs 1f",
    "movw r1, #:lower16:_stack_start",
    "movt r1, #:upper16:_stack_start",
    "mov sp, r1",
    "1:",
    "b.w hard_fault",
    ".size HardFault, . - HardFault",
    margin = const MARGIN,
);
