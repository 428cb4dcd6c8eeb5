//! Builds the node programs, for the emulated board, the host or WebAssembly, and identifies
//! them by their hashes.
//!
//! `program` describes a program, `motor_board` and `guard_board` build what is flashed, `cargo`
//! calls cargo, `error` lists the errors. [`flash`] and [`settings_pages`] make the bytes that are
//! flashed. [`setup`] installs what the build needs.

mod cargo;
mod error;
pub mod flash;
mod guard_board;
mod motor_board;
mod program;
pub mod settings_pages;
pub mod setup;

pub use cargo::changes_a_build;
pub use error::BuildError;
pub use guard_board::guard_board;
pub use motor_board::{MotorBoard, defective_axle, motor_board};
pub use program::{Board, Instruments, Program, Programs, hexadecimal};

use cargo::{Recipe, folder_of};
use program::program;

/// Builds the nodes of the robot with this guard program for `board`. In QEMU all nodes run that
/// program, which also contains the roles of the drives: nodes with the same program can share an
/// emulated machine. On other boards each role has a program of its own.
///
/// # Errors
/// Those of [`build_each`].
pub fn build(board: Board, guard: &str) -> Result<Programs, BuildError> {
    match board {
        Board::Qemu => of_roles(board, [guard; 3]),
        _ => build_each(board, guard),
    }
}

/// Builds a program for each role, with this one for the guard. Returns quickly if nothing has
/// changed. Installs what the build needs, see [`setup`].
///
/// May be called from several threads and programs at once: cargo lets one of them build and the
/// others wait.
///
/// # Errors
/// [`BuildError`], with cargo's last lines if the build fails.
pub fn build_each(board: Board, guard: &str) -> Result<Programs, BuildError> {
    of_roles(board, ["axle", "screw", guard])
}

/// Builds programs for axle, screw and guard.
fn of_roles(board: Board, names: [&str; 3]) -> Result<Programs, BuildError> {
    let recipe = Recipe::simulated(board, board.feature());
    let folder = folder_of(&recipe, &names)?;
    let [axle, screw, guard] = names.map(|name| program(board, &folder, name));
    Ok(Programs {
        board,
        axle: axle?,
        screw: screw?,
        guard: guard?,
    })
}

/// Builds the programs that measure the control code on the emulated core, in the same way as
/// [`build_each`].
///
/// # Errors
/// The same as [`build_each`].
pub fn instruments() -> Result<Instruments, BuildError> {
    let recipe = Recipe::simulated(Board::Qemu, "cost");
    let folder = folder_of(&recipe, &["cost", "ticks"])?;
    Ok(Instruments {
        cost: program(Board::Qemu, &folder, "cost")?,
        ticks: program(Board::Qemu, &folder, "ticks")?,
    })
}
