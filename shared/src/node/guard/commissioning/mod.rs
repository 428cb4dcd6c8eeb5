//! Commissioning of the sensors on the body: finds how the sensor board is mounted, the constant
//! errors of its sensors and the robot's own magnetic field, and checks the sign of every axis.
//!
//! The operator brings the robot into a position and requests a step. Nothing moves by itself. The
//! values found are the guard's settings; a client writes them and saves.
//!
//! [`interface`]: requests, progress and results. `sequence`: the steps, and what each finds.
//! `rest`: means of the readings at rest. `turn`: angles and fields of a turn.

mod interface;
mod rest;
mod sequence;
mod turn;

pub use interface::{Reason, Report, Values, progress, request};
pub use sequence::Commissioning;

use crate::math::sqrt;

/// Why a step is refused, and the value.
type Failure = (Reason, f32);

fn length([x, y, z]: [f32; 3]) -> f32 {
    sqrt(x * x + y * y + z * z)
}
