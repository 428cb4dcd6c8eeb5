//! Program that counts what the control code costs on the core, in executed instructions, under
//! QEMU's `-icount shift=8,sleep=off`.
//!
//! [`counter`] counts one call, [`inputs`] makes the inputs of the calls; the other files list what
//! is counted, with one file per part of the library. The host writes the number of calls per entry
//! (`u32`, little-endian) to standard input. It reads one line per entry: name, calls, minimum,
//! maximum, sum, address of the function. `cargo cost` does both and writes a table.

mod bus;
mod counter;
mod guards;
mod hylos;
mod inputs;
mod math;
mod model;
mod motor;
mod nodes;
mod stability;
mod traffic;

use crate::boards::mps2::semihosting::{Stream, exit};
use counter::Table;

/// Counts everything, writes the lines and ends the emulator. Ends it with failure if the counter
/// does not pass its own check ([`Table::controls`]).
pub fn run() -> ! {
    let (Some(input), Some(output)) = (Stream::standard_input(), Stream::standard_output()) else {
        exit(false)
    };
    let mut calls = [0; 4];
    if !input.read_exact(&mut calls) {
        exit(false);
    }
    let Some(mut table) = Table::new(u32::from_le_bytes(calls), output) else {
        exit(false)
    };
    if !table.controls() {
        exit(false);
    }
    math::count(&mut table);
    stability::count(&mut table);
    model::count(&mut table);
    hylos::count(&mut table);
    motor::count(&mut table);
    nodes::count(&mut table);
    guards::count(&mut table);
    bus::count(&mut table);
    exit(true)
}
