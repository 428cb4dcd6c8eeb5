//! Simulated parts of a board, as values. The boards without hardware consist of them: `mps2`,
//! which is emulated, and `host`, which is a value in the simulator's process.
//!
//! `attached` is the motor with its rotor sensor, `chips` the bus of the sensor chips on the
//! robot's body, `flash` the memory of the settings, and `log_buffer` replaces the debug probe.

mod attached;
mod chips;
mod flash;
mod log_buffer;

pub use attached::AttachedMotor;
pub use chips::Bus;
pub use flash::{Files, Flash};
pub use log_buffer::LogBuffer;
pub use tautrack::motor::model::POWER_STAGE;
