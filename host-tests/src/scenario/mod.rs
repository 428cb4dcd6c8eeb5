//! Scenarios: one TOML file describes a run and the results that it must have.
//!
//! [`Description`] is the content of the file. [`Scenario`] is a description that passed every
//! check, so no later code checks it again. `operator` is the operator's section with its bounds,
//! `driver` reads it, `script` plays it during a run. `fault` lists the faults, `frame` the
//! frames of a client, `hand` moves the robot, `expect` the
//! expected results, `motor` the motors that differ from those of the robot,
//! `sensors` the rates of the sensors on the body, `sensor_errors` their constant errors. `check`
//! checks the other bounds, `error` reports errors with their place. The robots' sections are in
//! [`crate::robots`], the ground's values in [`crate::world::terrain`].

mod check;
mod description;
mod driver;
mod error;
mod expect;
mod fault;
mod frame;
mod hand;
mod motor;
mod operator;
mod script;
mod sensor_errors;
mod sensors;

pub use description::Description;
pub use error::ScenarioError;
pub use expect::Expect;
pub use fault::{Fault, FaultKind, SensorChip, Switch};
pub use frame::ClientFrame;
pub use hand::Motion;
pub use motor::Motor;
pub use operator::{Belts, Clearance, Event, Operator, OperatorRequest, When};
pub use script::{Ask, BusView, Script};
pub use sensor_errors::SensorErrors;
pub use sensors::Sensors;

use crate::bounds::Problem;
use serde::Serialize;
use std::path::Path;

/// A description that passed every check. It is read-only; [`Description::check`] makes one.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Scenario(Description);

impl std::ops::Deref for Scenario {
    type Target = Description;

    fn deref(&self) -> &Description {
        &self.0
    }
}

impl Scenario {
    /// Reads and checks a scenario file.
    ///
    /// # Errors
    /// Describes the first bad value, with file, line and column.
    pub fn load(path: &Path) -> Result<Self, ScenarioError> {
        let file = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(&text, &file),
            Err(error) => Err(ScenarioError::new(
                &file,
                Problem::Unreadable(error.to_string()),
            )),
        }
    }

    /// Checks the text of a scenario file; `file` is the name that errors show.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn parse(text: &str, file: &str) -> Result<Self, ScenarioError> {
        error::parse(text, file)?
            .check()
            .map_err(|problem| error::locate(problem, text, file))
    }

    /// Checks a description that does not come from a file; errors show the scenario's name in
    /// place of a file.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn checked(description: Description) -> Result<Self, ScenarioError> {
        let name = description.name.clone();
        description
            .check()
            .map_err(|problem| ScenarioError::new(&name, problem))
    }

    /// The same scenario with sensors at these rates. Errors of the scenario's sensors stay, unless
    /// `sensors` has others.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn with_sensors(&self, sensors: Sensors) -> Result<Self, ScenarioError> {
        Self::checked(Description {
            sensors: Sensors {
                errors: self.sensors.errors.or(sensors.errors),
                ..sensors
            },
            ..self.description()
        })
    }

    /// A copy of the description that can be changed and checked again, for sweeps and command-line
    /// options.
    pub fn description(&self) -> Description {
        self.0.clone()
    }
}
