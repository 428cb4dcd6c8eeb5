//! Starts a node program, natively or in QEMU, and talks to it over the lockstep link.
//!
//! `programs`: which there are. `process`: one that runs. `settings`: what it is told.

#![allow(dead_code, unused_imports)] // each test program uses a part of it

mod process;
mod programs;
mod settings;

pub use process::Node;
pub use programs::{ROLES, elf};
pub use settings::{MOTOR, settings};
