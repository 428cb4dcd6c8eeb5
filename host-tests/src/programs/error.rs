//! Why there are no programs.

use super::Board;
use super::setup::Missing;
use super::setup::checkout::NoCheckout;
use std::path::PathBuf;
use std::{fmt, io};

/// Why there are no programs.
#[derive(Debug)]
pub enum BuildError {
    /// There are no sources.
    NoCheckout(NoCheckout),
    /// Something needed is not installed.
    Missing(Missing),
    /// cargo does not start.
    Cargo(io::Error),
    /// cargo fails.
    Failed {
        /// The board that was built for.
        board: Board,
        /// The last lines that cargo wrote.
        output: String,
    },
    /// cargo succeeds, but the program cannot be read.
    Unreadable {
        /// The program.
        path: PathBuf,
        /// Why.
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
                write!(f, "the nodes for {board:?} do not build:\n{output}")
            }
            Self::Unreadable { path, error } => {
                write!(f, "cannot read {}: {error}", path.display())
            }
        }
    }
}

impl std::error::Error for BuildError {}
