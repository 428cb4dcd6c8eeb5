//! Scenarios: one TOML file says what a run is made of and what must come out of it.
//!
//! [`Description`] is the file as written; [`Scenario`] is a description that passed every check,
//! so nothing checks again. `operator` is the section of that name with its bounds, `driver` reads
//! who the operator is, `fault` is what can go wrong, `expect` what must come out, `check` holds
//! the other bounds, `error` says what was bad and where, `script` plays the operator. The robots'
//! sections are in [`crate::robots`], the ground's values in [`crate::world::terrain`].

mod check;
mod description;
mod driver;
mod error;
mod expect;
mod fault;
mod operator;
mod script;

pub use description::Description;
pub use error::ScenarioError;
pub use expect::Expect;
pub use fault::{Fault, FaultKind};
pub use operator::{Event, Operator, OperatorRequest, When};
pub use script::{Ask, BusView, Script};

use crate::bounds::Problem;
use serde::Serialize;
use std::path::Path;

/// A description that passed every check. Read-only; [`Description::check`] makes one.
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
    /// Says what is wrong with the first bad value, with file, line and column.
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

    /// Checks a description that no file holds; its errors show the scenario's name.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn checked(description: Description) -> Result<Self, ScenarioError> {
        let name = description.name.clone();
        description
            .check()
            .map_err(|problem| ScenarioError::new(&name, problem))
    }

    /// A copy to change and check again, for sweeps and command-line switches.
    pub fn description(&self) -> Description {
        self.0.clone()
    }
}
