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

/// Calls per entry of [`Table::kernel`].
const CALLS: u32 = 1_000;

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

/// Returns a callee that executes `control` and changes no state.
fn callee<S>(control: extern "C" fn()) -> fn(&mut S) {
    // SAFETY: the two functions above access neither memory nor arguments.
    unsafe { core::mem::transmute::<extern "C" fn(), fn(&mut S)>(control) }
}

/// Writes the counts to the host.
pub struct Table {
    output: Stream,
}

impl Table {
    /// Starts the timer. Returns `None` if the core's peripherals are already taken.
    pub fn new(output: Stream) -> Option<Self> {
        let mut timer = Peripherals::take()?.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(0x00ff_ffff);
        timer.clear_current();
        timer.enable_counter();
        Some(Self { output })
    }

    /// Checks the counter, and writes both controls like any entry. Returns `None` unless an empty
    /// call reads 0 and ten `nop`s read 10.
    pub fn controls(&mut self) -> Option<()> {
        let controls: [(_, extern "C" fn(), _); 2] =
            [("empty call", nothing, 0), ("ten nops", ten_nops, 10)];
        for (name, control, expected) in controls {
            let counts = [(); 100].map(|()| instructions(&mut (), callee(control)));
            self.write(name, counts.into_iter())?;
            counts
                .iter()
                .all(|count| *count == expected)
                .then_some(())?;
        }
        Some(())
    }

    /// Counts [`CALLS`] calls of `kernel` and writes the entry. `prepare` sets the inputs in the
    /// state before each call; it gets the number of the call. Returns `None` if the host has gone.
    pub fn kernel<S>(
        &mut self,
        name: &str,
        state: &mut S,
        mut prepare: impl FnMut(&mut S, u32, &mut Random),
        kernel: fn(&mut S),
    ) -> Option<()> {
        let mut random = Random::new();
        let counts = (0..CALLS).map(|call| {
            prepare(state, call, &mut random);
            instructions(state, kernel)
        });
        self.write(name, counts)
    }

    /// Writes minimum, maximum and mean of `counts`. Returns `None` if the host has gone.
    pub fn write(&mut self, name: &str, counts: impl Iterator<Item = u32>) -> Option<()> {
        let (mut calls, mut least, mut most, mut sum) = (0, u32::MAX, 0, 0);
        for count in counts {
            (least, most) = (least.min(count), most.max(count));
            (calls, sum) = (calls + 1, sum + count);
        }
        writeln!(self.output, "{name};{least};{most};{}", sum / calls.max(1)).ok()
    }
}

/// Counts the instructions of `kernel(state)` without its return.
pub fn instructions<S>(state: &mut S, kernel: fn(&mut S)) -> u32 {
    let overhead = ticks(state, black_box(callee(nothing)));
    let whole = ticks(state, black_box(kernel));
    // Divides by 6.4 ticks per instruction and rounds to nearest. A callee without instructions may
    // read one tick less than `overhead`.
    (((whole as i32 - overhead as i32) * 5 + 16) >> 5) as u32
}

/// Returns the `SysTick` ticks between a reading before and one after the call. All callees of a
/// type share this one call site.
#[inline(never)]
fn ticks<S>(state: &mut S, callee: fn(&mut S)) -> u32 {
    let before = SYST::get_current();
    callee(state);
    let after = SYST::get_current();
    // The timer counts down.
    before.wrapping_sub(after) & 0x00ff_ffff
}
