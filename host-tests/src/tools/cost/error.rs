//! Errors that prevent a measurement.

use crate::programs::BuildError;
use std::{fmt, io};

/// An error that prevents a measurement.
#[derive(Debug)]
pub enum CostError {
    /// The programs do not build.
    Build(BuildError),
    /// The emulator or a file cannot be used.
    Io(io::Error),
    /// A program, a file or the emulator's output is not in the expected form.
    Malformed(String),
}

impl fmt::Display for CostError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Build(error) => error.fmt(f),
            Self::Io(error) => error.fmt(f),
            Self::Malformed(what) => f.write_str(what),
        }
    }
}

impl std::error::Error for CostError {}

impl From<BuildError> for CostError {
    fn from(error: BuildError) -> Self {
        Self::Build(error)
    }
}

impl From<io::Error> for CostError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}
