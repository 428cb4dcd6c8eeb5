//! Counts the instructions of one call.
//!
//! With `-icount shift=8` an instruction takes 256 ns of virtual time, and `SysTick` counts in
//! steps of 40 ns. An instruction is therefore 6.4 ticks, so that the count of one call is exact to
//! the instruction. The count of a callee that only returns, at the same call site, is subtracted;
//! the result is the callee's instructions without its return.

use super::inputs::Random;
use crate::boards::mps2::semihosting::Stream;
use core::arch::naked_asm;
use core::fmt::Write;
use core::hint::black_box;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{Peripherals, SYST};

/// Types for which every bit pattern is a value, so that a callee that only returns may replace any
/// function that returns such a type.
///
/// # Safety
/// Every bit pattern of the type must be valid.
pub unsafe trait Plain {}
// SAFETY: numbers and `()` have no invalid bit patterns.
unsafe impl Plain for () {}
// SAFETY: as above.
unsafe impl Plain for i32 {}
// SAFETY: as above.
unsafe impl Plain for f32 {}
// SAFETY: as above.
unsafe impl Plain for (i32, i32) {}
// SAFETY: as above.
unsafe impl Plain for (f32, f32) {}

#[unsafe(naked)]
extern "C" fn nothing() {
    naked_asm!("bx lr")
}

#[unsafe(naked)]
extern "C" fn ten_nops() {
    naked_asm!(
        "nop", "nop", "nop", "nop", "nop", "nop", "nop", "nop", "nop", "nop", "bx lr"
    )
}

/// Minimum, maximum and sum of the counts of several calls.
#[derive(Clone, Copy)]
pub struct Count {
    calls: u32,
    least: u32,
    most: u32,
    sum: u64,
}

impl Count {
    /// The counts of no calls.
    pub const NONE: Self = Self {
        calls: 0,
        least: u32::MAX,
        most: 0,
        sum: 0,
    };

    /// Adds the count of one call.
    pub fn take(&mut self, instructions: u32) {
        self.calls += 1;
        self.least = self.least.min(instructions);
        self.most = self.most.max(instructions);
        self.sum += u64::from(instructions);
    }
}

/// Writes the counts to the host.
pub struct Table {
    calls: u32,
    output: Stream,
}

impl Table {
    /// Creates a table with `calls` calls per entry and starts the timer. Returns `None` if the
    /// core's peripherals are already taken.
    pub fn new(calls: u32, output: Stream) -> Option<Self> {
        let mut timer = Peripherals::take()?.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(0x00ff_ffff);
        timer.clear_current();
        timer.enable_counter();
        Some(Self { calls, output })
    }

    /// Number of calls per entry.
    pub fn calls(&self) -> u32 {
        self.calls
    }

    /// Checks the counter: returns whether an empty call reads 0 and ten `nop`s read 10. Both are
    /// written like any entry.
    pub fn controls(&mut self) -> bool {
        // SAFETY: both functions access neither memory nor arguments.
        let [empty, nops] = [nothing as extern "C" fn(), ten_nops].map(|control| unsafe {
            core::mem::transmute::<extern "C" fn(), fn(&mut (), ())>(control)
        });
        let mut right = true;
        for (name, control, expected) in [("empty call", empty, 0), ("ten nops", nops, 10)] {
            let mut count = Count::NONE;
            for _ in 0..100 {
                let read = instructions(&mut (), (), control);
                count.take(read);
                right &= read == expected;
            }
            self.write(name, &count, control as usize);
        }
        right
    }

    /// Counts `kernel` over the inputs that `inputs` returns for each call number, and writes the
    /// entry.
    pub fn kernel<S, I: Copy, O: Plain>(
        &mut self,
        name: &str,
        state: &mut S,
        mut inputs: impl FnMut(&mut S, u32, &mut Random) -> I,
        kernel: fn(&mut S, I) -> O,
    ) {
        let (mut count, mut random) = (Count::NONE, Random::new());
        for call in 0..self.calls {
            let input = inputs(state, call, &mut random);
            count.take(instructions(state, input, kernel));
        }
        self.write(name, &count, kernel as usize);
    }

    /// Writes one entry. Ignores an error: it means that the host has gone, and then the emulator
    /// ends by itself.
    pub fn write(&mut self, name: &str, count: &Count, address: usize) {
        let Count {
            calls,
            least,
            most,
            sum,
        } = count;
        let _ = writeln!(
            self.output,
            "{name};{calls};{least};{most};{sum};{:#x}",
            address & !1
        );
    }
}

/// Counts the instructions of `kernel(state, input)` without its return.
pub fn instructions<S, I: Copy, O: Plain>(
    state: &mut S,
    input: I,
    kernel: fn(&mut S, I) -> O,
) -> u32 {
    // SAFETY: the callee only returns. It does not change the state, and any contents of the
    // result's registers are a valid value.
    let empty = unsafe {
        core::mem::transmute::<extern "C" fn(), fn(&mut S, I) -> O>(nothing as extern "C" fn())
    };
    let overhead = ticks(state, input, black_box(empty));
    let whole = ticks(state, input, black_box(kernel));
    // Divides by 6.4 ticks per instruction and rounds to nearest. A callee without instructions may
    // read one tick less than `overhead`.
    (((whole as i32 - overhead as i32) * 5 + 16) >> 5) as u32
}

/// Returns the `SysTick` ticks between a reading before and one after the call. All callees of a
/// type share this one call site.
#[inline(never)]
fn ticks<S, I: Copy, O: Plain>(state: &mut S, input: I, callee: fn(&mut S, I) -> O) -> u32 {
    let before = SYST::get_current();
    let output = callee(state, input);
    let after = SYST::get_current();
    black_box(output);
    // The timer counts down.
    before.wrapping_sub(after) & 0x00ff_ffff
}
