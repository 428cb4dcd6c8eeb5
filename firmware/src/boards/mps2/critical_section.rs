//! Critical section of a core without interrupts: it does nothing.
//!
//! On the emulated board, cortex-m's implementation masks and unmasks the interrupts. Each of these
//! two instructions makes QEMU leave its translated code, about 80 times in a step. The programs
//! `cost` and `ticks` keep cortex-m's implementation (feature `cost`), because its instructions
//! count on a real board.

use critical_section::{Impl, RawRestoreState, set_impl};

struct NoInterrupts;
set_impl!(NoInterrupts);

// SAFETY: the board has one core and one thread, and enables no interrupt. Its only exception
// handler that can run is that of a hard fault, which ends the emulator and never returns. Nothing
// can therefore run between `acquire` and `release` but the code in the section itself.
unsafe impl Impl for NoInterrupts {
    unsafe fn acquire() -> RawRestoreState {}

    unsafe fn release((): RawRestoreState) {}
}
