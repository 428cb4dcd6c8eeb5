//! Why a suite could not be run.

use crate::scenario::ScenarioError;
use crate::simulator::run::RunError;
use std::fmt;
use std::path::PathBuf;

/// Why the suite could not be run.
#[derive(Debug)]
pub enum SuiteError {
    /// A folder cannot be read.
    Folder(PathBuf, std::io::Error),
    /// A scenario is bad.
    Scenario(ScenarioError),
    /// A run broke.
    Run(String, RunError),
}

impl fmt::Display for SuiteError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Folder(path, error) => write!(f, "cannot read {}: {error}", path.display()),
            Self::Scenario(error) => write!(f, "{error}"),
            Self::Run(name, error) => write!(f, "{name}: {error}"),
        }
    }
}

impl std::error::Error for SuiteError {}
