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
    let recipe = Recipe {
        board: "esc1",
        target: TARGET,
        features: "esc1",
        profile: "board",
        flashed_with_log: Some(FLASHED_LOG),
        small_library: true,
    };
    let folder = folder_of(&recipe, &["loader", "axle", "screw"])?;
    Ok(MotorBoard {
        loader: identify(folder.join("loader"))?,
        axle: identify(folder.join("axle"))?,
        screw: identify(folder.join("screw"))?,
    })
}
