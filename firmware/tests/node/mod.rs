//! Starts a node program, natively or in QEMU, and communicates with it over the lockstep link.
//!
//! `programs` builds the programs, `process` runs one on one `processor`, and `settings` holds its
//! settings.

#![allow(dead_code, unused_imports)] // each test program uses only a part

mod process;
mod processor;
mod programs;
mod settings;

pub use process::Node;
pub use programs::{ROLES, elf};
pub use settings::{MOTOR, settings};
