//! Tests of the ticks of the nodes.

mod any_input;
mod drive_faults;
mod guard;
#[cfg(feature = "lockstep")]
mod motor_faults;
