//! Critical sections, which stop all interrupts. The bus stack has 200 of them, so they are calls:
//! inlined, as the library of the core has them, they take 2 KB.

use cortex_m::interrupt;
use cortex_m::register::primask;
use critical_section::{Impl, RawRestoreState, set_impl};

struct AllInterrupts;
set_impl!(AllInterrupts);

// SAFETY: the chip has one core, and no code between both calls runs with interrupts enabled.
unsafe impl Impl for AllInterrupts {
    #[inline(never)]
    unsafe fn acquire() -> RawRestoreState {
        let enabled = primask::read().is_active();
        interrupt::disable();
        enabled
    }

    #[inline(never)]
    unsafe fn release(enabled: RawRestoreState) {
        if enabled {
            // SAFETY: they were enabled when the section began.
            unsafe { interrupt::enable() }
        }
    }
}
