//! Errors that keep a suite from running.

use crate::scenario::ScenarioError;
use crate::simulator::run::RunError;
use std::fmt;
use std::path::PathBuf;

/// An error that keeps a suite from running.
#[derive(Debug)]
pub enum SuiteError {
    /// A folder cannot be read.
    Folder(PathBuf, std::io::Error),
    /// A scenario is not valid.
    Scenario(ScenarioError),
    /// A run failed.
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
