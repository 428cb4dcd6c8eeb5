//! Builds the programs of the guard's board, which are flashed and do not run in the simulator.

use super::program::identify;
use super::setup::TARGET;
use super::setup::build::{FLASHED_LOG, Recipe, folder_of};
use super::{BuildError, Program};

/// Builds these guard programs for the guard's board. Returns quickly if nothing has changed.
///
/// # Errors
/// [`BuildError`], with cargo's last lines if the build fails.
pub fn guard_board(guards: &[&str]) -> Result<Vec<Program>, BuildError> {
    let recipe = Recipe {
        board: "g474",
        target: TARGET,
        features: "g474",
        profile: "board",
        flashed_with_log: Some(FLASHED_LOG),
        small_library: false,
    };
    let folder = folder_of(&recipe, guards)?;
    let programs = guards.iter().map(|guard| identify(folder.join(guard)));
    programs.collect()
}
