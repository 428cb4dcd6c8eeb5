//! Model of the motor board's chip, which executes flash images.
//!
//! `stm32g431` has core, memories and peripherals.

#[allow(clippy::missing_panics_doc)] // each of its panics is a mistake in the model
mod stm32g431;

pub use stm32g431::*;
