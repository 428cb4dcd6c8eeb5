//! Lockstep boards, which have no hardware: a message from the simulator starts one step of virtual
//! time, and the answer carries the results.
//!
//! The lockstep boards (`mps2`, `native`, `wasm`) differ only in how the messages reach their
//! `machine`, which answers them: `link` carries them over a [`Pipe`], and a `wasm` node is called.
//! `power_up` handles the start message and `step` the step messages. `attached` is the motor with
//! its rotor sensor. `inputs` holds the sensor readings, `chips` the sensor chips on the robot's
//! body, `brake` the output to the brake, `flash` the settings in flash, `clock` provides timer and
//! executor, `critical_section` is that of a core without interrupts, `log_buffer` replaces the
//! debug probe (with `text_log` where the records are text) and `starvation` the watchdog.

mod attached;
mod brake;
mod chips;
pub mod clock;
#[cfg(any(all(target_os = "none", not(feature = "cost")), target_family = "wasm"))]
mod critical_section;
mod flash;
mod inputs;
#[cfg(not(target_family = "wasm"))]
mod link;
pub mod log_buffer;
mod machine;
mod power_up;
mod starvation;
mod step;
#[cfg(not(target_os = "none"))]
pub mod text_log;

pub use brake::set_brake;
pub use chips::start_sensors;
#[cfg(not(target_family = "wasm"))]
pub use flash::Files;
pub use flash::Flash;
pub use inputs::{encoder, encoder_broken, index, supply_voltage, switches};
#[cfg(not(target_family = "wasm"))]
pub use link::{Pipe, run};
pub use machine::{End, Machine};
pub use power_up::serial_number;
pub use starvation::feed_watchdog;

#[cfg(target_os = "none")]
use crate::roles::Role;

/// Static variables that a node needs again after the turn of another one. The others are as at
/// power-up, or nobody reads what they hold. Each value includes the next.
#[cfg(target_os = "none")]
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Kept {
    /// All.
    All,
    /// All but the section `.seldom`.
    Guard,
    /// As `Guard`, without those that only a guard uses.
    Screw,
    /// As `Screw`, without those that only a screw uses.
    Axle,
}

/// Prepares a node with this role for the turn of another one. Returns what must be kept for it.
#[cfg(target_os = "none")]
pub fn kept(role: &Role) -> Kept {
    if flash::release() || log_buffer::used() || crate::current_loop::capture_used() {
        return Kept::All;
    }
    match role.name {
        "guard" => Kept::Guard,
        "screw" => Kept::Screw,
        "axle" => Kept::Axle,
        _ => Kept::All,
    }
}

pub use tautrack::motor::model::POWER_STAGE;
