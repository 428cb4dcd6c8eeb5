//! Counts the instructions of one call.
//!
//! With `-icount shift=8` an instruction takes 256 ns of virtual time and `SysTick` counts in steps of 40 ns: 6.4 ticks, so that one
//! call is exact to the instruction. The same call site with a callee that only returns is subtracted, so what is left is the
//! callee without its return.

use super::inputs::Random;
use crate::boards::mps2::semihosting::Stream;
use core::arch::naked_asm;
use core::fmt::Write;
use core::hint::black_box;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{Peripherals, SYST};

/// Types of which any bits are a value, so that a callee that only returns may stand for any function that gives one.
///
/// # Safety
/// Every bit pattern of the type must be valid.
pub unsafe trait Plain {}
// SAFETY: numbers, and nothing, have no invalid bits.
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

/// Counts of several calls.
#[derive(Clone, Copy)]
pub struct Count {
    calls: u32,
    least: u32,
    most: u32,
    sum: u64,
}

impl Count {
    /// Counts of no calls.
    pub const NONE: Self = Self {
        calls: 0,
        least: u32::MAX,
        most: 0,
        sum: 0,
    };

    /// Takes the count of one more call.
    pub fn take(&mut self, instructions: u32) {
        self.calls += 1;
        self.least = self.least.min(instructions);
        self.most = self.most.max(instructions);
        self.sum += u64::from(instructions);
    }
}

/// The counts on their way to the host.
pub struct Table {
    calls: u32,
    output: Stream,
}

impl Table {
    /// Table of so many calls per entry; `None` without a timer.
    pub fn new(calls: u32, output: Stream) -> Option<Self> {
        let mut timer = Peripherals::take()?.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(0x00ff_ffff);
        timer.clear_current();
        timer.enable_counter();
        Some(Self { calls, output })
    }

    /// Calls per entry.
    pub fn calls(&self) -> u32 {
        self.calls
    }

    /// Whether an empty call reads 0 and ten `nop`s read 10; both are written like any entry.
    pub fn controls(&mut self) -> bool {
        // SAFETY: both touch neither memory nor arguments.
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

    /// Counts `kernel` over the inputs that `inputs` makes from the number of the call.
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

    /// Writes one entry. The host has gone if that fails; the emulator then ends by itself.
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

/// Instructions of `kernel(state, input)`, its return not counted.
pub fn instructions<S, I: Copy, O: Plain>(
    state: &mut S,
    input: I,
    kernel: fn(&mut S, I) -> O,
) -> u32 {
    // SAFETY: the callee only returns; it leaves the state as it is, and whatever the result's registers hold is a value.
    let empty = unsafe {
        core::mem::transmute::<extern "C" fn(), fn(&mut S, I) -> O>(nothing as extern "C" fn())
    };
    let overhead = ticks(state, input, black_box(empty));
    let whole = ticks(state, input, black_box(kernel));
    // 6.4 ticks each, to nearest: an empty call may read a tick less than nothing.
    (((whole as i32 - overhead as i32) * 5 + 16) >> 5) as u32
}

/// `SysTick` ticks between a reading before and one after the call: one call site for every callee of a type.
#[inline(never)]
fn ticks<S, I: Copy, O: Plain>(state: &mut S, input: I, callee: fn(&mut S, I) -> O) -> u32 {
    let before = SYST::get_current();
    let output = callee(state, input);
    let after = SYST::get_current();
    black_box(output);
    // It counts down.
    before.wrapping_sub(after) & 0x00ff_ffff
}
