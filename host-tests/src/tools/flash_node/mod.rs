//! `cargo flash-node`: writes programs and settings of a board through a debug probe. The
//! program probe-rs talks to the probe.
//!
//! `command` is the command line, `settings` collects the settings of a node, `option_bytes` looks
//! where the chip starts, `faults` prints the fault log, and `probe` calls probe-rs.

mod command;
mod faults;
mod option_bytes;
mod probe;
mod settings;

pub use command::main;
