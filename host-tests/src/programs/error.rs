//! Errors of building the node programs.

use super::setup::Missing;
use super::setup::checkout::NoCheckout;
use std::path::PathBuf;
use std::{fmt, io};

/// Reason why node programs could not be built.
#[derive(Debug)]
pub enum BuildError {
    /// No checkout with the sources was found.
    NoCheckout(NoCheckout),
    /// A needed program is not installed.
    Missing(Missing),
    /// cargo does not start.
    Cargo(io::Error),
    /// cargo runs and fails.
    Failed {
        /// Name of the board that the programs were built for.
        board: String,
        /// The last lines of cargo's output.
        output: String,
    },
    /// cargo succeeds, but a program cannot be read.
    Unreadable {
        /// Path of the program.
        path: PathBuf,
        /// Error of the read.
        error: io::Error,
    },
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::NoCheckout(error) => write!(f, "{error}"),
            Self::Missing(missing) => write!(f, "{missing}"),
            Self::Cargo(error) => write!(f, "cargo does not start: {error}"),
            Self::Failed { board, output } => {
                write!(f, "the nodes for {board} do not build:\n{output}")
            }
            Self::Unreadable { path, error } => {
                write!(f, "cannot read {}: {error}", path.display())
            }
        }
    }
}

impl std::error::Error for BuildError {}
