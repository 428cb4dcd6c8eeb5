//! The boards that a node runs on, behind one contract.
//!
//! A new board is a new folder here with one type that implements [`Board`], a cargo feature that
//! selects it, and a link script in `build.rs` (firmware/README.md, "Add a board"). Nothing else of
//! the firmware knows which board it is on.

mod lockstep;

#[cfg(all(target_os = "none", feature = "mps2"))]
pub(crate) mod mps2;
#[cfg(all(target_os = "none", feature = "mps2"))]
pub use mps2::Mps2 as Selected;

#[cfg(not(target_os = "none"))]
mod native;
#[cfg(not(target_os = "none"))]
pub use native::Native as Selected;

#[cfg(all(target_os = "none", not(feature = "mps2")))]
compile_error!("choose a board, for instance --features mps2");

pub use crate::current_loop::Bridge;
use crate::roles::Role;
use tautrack::sensors::{BodySensors, Switches};

/// The contract between a board and the rest of the firmware. A board is a singleton, so its methods take no `self`.
///
/// What a board *does* by itself, besides answering these methods:
/// * It calls [`crate::current_loop::pwm_period`] once in every PWM period, in its highest interrupt, and applies the
///   returned [`Bridge`] from the next period on. Before the first call, and from a panic on, its bridge is off.
/// * It puts every frame that the bus delivers into [`crate::bus::RECEIVED`], and sends those of
///   [`crate::bus::TRANSMIT`] as the bus has room, oldest first; both are safe in an interrupt.
/// * It puts every byte that its serial line delivers into [`crate::serial::RECEIVED`], where it has such a line.
/// * It drives the clock of `embassy-time` in microseconds since power-up, and polls the executor.
/// * Its panic handler opens the bridge before anything else.
pub trait Board {
    /// The board's name, as in its folder.
    const NAME: &'static str;
    /// PWM periods per second, and so calls of [`crate::current_loop::pwm_period`].
    const PWM_HZ: u32;

    /// Starts the board, reads the settings, has `role` spawn its tasks, and runs them for ever.
    fn run(role: &'static Role) -> !;
    /// Counts of the rotor's encoder since power-up; wraps at both ends of `i32`.
    fn encoder() -> i32;
    /// Supply voltage, V; 0 while unknown.
    fn supply_voltage() -> f32;
    /// Switches of the axle.
    fn switches() -> Switches;
    /// Sensors on the robot's body, where the board has them.
    fn body() -> Option<BodySensors>;
    /// Feeds the board's watchdog, which resets the node [`crate::watchdog::PERIOD_US`] after it
    /// was last fed. The firmware calls it when all of its parts have run since the call before,
    /// and nobody else does.
    fn feed_watchdog();
}

/// Rate of the control task, Hz, on every board.
pub const CONTROL_HZ: u32 = 1_000;
