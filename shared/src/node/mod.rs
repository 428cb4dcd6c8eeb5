//! What each node does in one tick: inputs in, outputs out. No I/O, no waiting, no clock but the time in the inputs.

pub mod axle;
pub mod guard;
pub mod screw;
mod supervisor;
