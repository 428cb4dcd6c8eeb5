//! `cargo flash-node`: writes programs and settings of a board through a debug probe. The
//! program probe-rs talks to the probe.
//!
//! `command` is the command line, `settings` collects the settings of a node, and `probe` calls
//! probe-rs.

mod command;
mod probe;
mod settings;

pub use command::main;
