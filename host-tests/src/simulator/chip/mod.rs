//! Model of the boards' chips, which executes flash images.
//!
//! `stm32g4` has the chip: core, memories and peripherals; `registers` are the words of the
//! latter. `motor` is the motor at its bridge,
//! with the analogue circuits between them. `log` reads the log of an image. [`board`] answers the
//! steps of a run.

pub mod board;
mod log;
mod motor;
mod registers;
#[allow(clippy::missing_panics_doc)] // each of its panics is a mistake in the model
mod stm32g4;

pub use stm32g4::*;
