//! A node in this process, or the same in QEMU.
//!
//! `program` builds the program of the emulated board, `process` runs it, `running` is a node of
//! either kind, and `settings` holds its settings.

#![allow(dead_code, unused_imports)] // each test program uses only a part

mod process;
mod program;
mod running;
mod settings;

pub use program::elf;
pub use running::{Node, ROLES};
pub use settings::{MOTOR, settings};
