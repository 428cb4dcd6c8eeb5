//! Describes the runs of the operators' suite.

use crate::robots::Kind;
use crate::scenario::{Scenario, Sensors};
use crate::tools::suite::SuiteError;
use crate::tools::suite::draw::operators::draw;

/// Which runs the suite makes.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// The robot.
    pub robot: Kind,
    /// Whether the guard's filter is on.
    pub guard: bool,
    /// Number of runs.
    pub runs: u64,
    /// Seed of all runs.
    pub seed: u64,
    /// Rates of the sensors on the body.
    pub sensors: Sensors,
}

/// The scenario of one run.
///
/// # Errors
/// [`SuiteError::Scenario`] if it is out of bounds.
pub fn drawn(plan: &Plan, number: u64, again: u64) -> Result<Scenario, SuiteError> {
    draw(plan.robot, plan.guard, plan.seed, number, again)
        .and_then(|scenario| scenario.with_sensors(plan.sensors))
        .map_err(SuiteError::Scenario)
}
