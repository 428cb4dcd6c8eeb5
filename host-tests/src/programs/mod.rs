//! Builds the node programs and identifies them by their hashes.
//!
//! `program` describes a program, `motor_board` and `guard_board` build what is flashed. [`flash`]
//! and [`settings_pages`] make the bytes that are flashed. [`setup`] calls cargo for the boards,
//! and installs what the build needs. A page on the web builds no programs: it has
//! [`Programs::in_process`] alone.

#[cfg(unix)]
pub mod flash;
#[cfg(unix)]
mod guard_board;
#[cfg(unix)]
mod motor_board;
mod program;
pub mod settings_pages;

#[cfg(unix)]
pub use guard_board::guard_board;
#[cfg(unix)]
pub use motor_board::{MotorBoard, motor_board};
pub use program::{Board, Instruments, Program, Programs, hexadecimal};
#[cfg(unix)]
pub use tautrack_setup as setup;
#[cfg(unix)]
pub use tautrack_setup::build::{BuildError, changes_a_build};

#[cfg(unix)]
use program::identify;
#[cfg(unix)]
use setup::build::{emulated, folder_of};

/// Builds the program that all nodes of a robot run on `board`: that of its guard, which also
/// contains the roles of the drives. Returns quickly if nothing has changed. Installs what the
/// build needs, see [`setup`].
///
/// May be called from several threads and programs at once: cargo lets one of them build and the
/// others wait.
///
/// # Errors
/// [`BuildError`], with cargo's last lines if the build fails.
#[cfg(unix)]
pub fn build(board: Board, guard: &str) -> Result<Programs, BuildError> {
    let nodes = match board {
        Board::Host => program::own(guard)?,
        Board::Qemu => identify(folder_of(&emulated("mps2"), &[guard])?.join(guard))?,
        Board::Image => guard_board(&[guard])?.remove(0),
    };
    Ok(Programs { board, nodes })
}

/// Builds the programs that measure the control code on the emulated core, in the same way as
/// [`build`].
///
/// # Errors
/// The same as [`build`].
#[cfg(unix)]
pub fn instruments() -> Result<Instruments, BuildError> {
    let folder = folder_of(&emulated("cost"), &["cost", "ticks"])?;
    Ok(Instruments {
        cost: identify(folder.join("cost"))?,
        ticks: identify(folder.join("ticks"))?,
    })
}
