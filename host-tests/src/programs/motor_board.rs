//! Builds the programs of the motor board, which are flashed and do not run in the simulator.

use super::program::identify;
use super::setup::TARGET;
use super::setup::build::{FLASHED_LOG, Recipe, folder_of};
use super::{BuildError, Program};

/// Programs of the motor board.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct MotorBoard {
    /// Checks the application and starts it.
    pub loader: Program,
    /// Application of an axle.
    pub axle: Program,
    /// Application of the screw.
    pub screw: Program,
}

/// Builds the programs of the motor board. Returns quickly if nothing has changed.
///
/// # Errors
/// [`BuildError`], with cargo's last lines if the build fails.
pub fn motor_board() -> Result<MotorBoard, BuildError> {
    let folder = folder_of(&recipe("esc1"), &["loader", "axle", "screw"])?;
    Ok(MotorBoard {
        loader: identify(folder.join("loader"))?,
        axle: identify(folder.join("axle"))?,
        screw: identify(folder.join("screw"))?,
    })
}

/// Builds the axle that has a defect on purpose, which its static variable `DEFECT` selects.
///
/// # Errors
/// The same as [`motor_board`].
pub fn defective_axle() -> Result<Program, BuildError> {
    let folder = folder_of(&recipe("defects"), &["defective_axle"])?;
    identify(folder.join("defective_axle"))
}

fn recipe(features: &str) -> Recipe<'_> {
    Recipe {
        board: "esc1",
        target: TARGET,
        features,
        profile: "board",
        flashed_with_log: Some(FLASHED_LOG),
        small_library: true,
    }
}
