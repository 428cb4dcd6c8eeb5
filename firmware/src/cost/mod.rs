//! Program that counts the instructions which the control code executes on the core, under QEMU's
//! `-icount shift=8,sleep=off`.
//!
//! [`counter`] counts one call and writes the counts, [`inputs`] and [`traffic`] make the inputs of
//! the calls. The other files list what is counted: single functions, the loops of a motor, the
//! ticks of drives, the guards and models of the [`robots`], and frames of the bus. The program
//! writes one line per entry: name, minimum, maximum, mean. `cargo cost` runs it and prints a
//! table.

mod bus;
mod counter;
mod drives;
mod guards;
mod inputs;
mod kernels;
mod motor;
mod robots;
mod traffic;

use crate::boards::mps2::semihosting::{Stream, exit};
use counter::Table;

/// Counts everything, writes the lines and ends the emulator. Ends it with failure if the counter
/// does not pass its own check ([`Table::controls`]) or an entry cannot be counted.
pub fn run() -> ! {
    exit(count().is_some())
}

/// Returns `None` at the first entry that cannot be counted.
fn count() -> Option<()> {
    let mut table = Table::new(Stream::standard_output()?)?;
    table.controls()?;
    kernels::count(&mut table)?;
    motor::count(&mut table)?;
    drives::count(&mut table)?;
    robots::count(&mut table)?;
    bus::count(&mut table)
}
