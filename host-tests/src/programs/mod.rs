//! Builds the node programs, for the emulated board or for the host, and says exactly which
//! programs they are.
//!
//! `program` is what they are, `cargo` calls cargo, `error` is why it fails. [`setup`] installs
//! what that takes.

mod cargo;
mod error;
mod program;
pub mod setup;

pub use cargo::changes_a_build;
pub use error::BuildError;
pub use program::{Board, Instruments, Program, Programs, hexadecimal};

use cargo::folder_of;
use program::program;

/// Builds the nodes of the robot with this guard program for `board`; quick when nothing has
/// changed. Installs what that takes, see [`setup`].
///
/// May be called from several threads and programs at once: cargo lets one of them build and the
/// others wait.
///
/// # Errors
/// [`BuildError`], with cargo's last lines when the build fails.
pub fn build(board: Board, guard: &str) -> Result<Programs, BuildError> {
    let folder = folder_of(board, &["axle", "screw", guard])?;
    Ok(Programs {
        board,
        axle: program(&folder, "axle")?,
        screw: program(&folder, "screw")?,
        guard: program(&folder, guard)?,
    })
}

/// Builds what measures the control code on the emulated core, as [`build`] builds the nodes.
///
/// # Errors
/// As [`build`].
pub fn instruments() -> Result<Instruments, BuildError> {
    let folder = folder_of(Board::Qemu, &["cost", "ticks"])?;
    Ok(Instruments {
        cost: program(&folder, "cost")?,
        ticks: program(&folder, "ticks")?,
    })
}
