//! What is wrong with a document, and where.

use std::fmt;

/// What is wrong with a document; displays as one sentence.
#[derive(Clone, Debug, PartialEq)]
pub enum EvaluateError {
    /// It cannot be read.
    Unreadable(String),
    /// It is not JSON.
    Malformed {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What the parser says, the place included.
        message: String,
    },
    /// No group has this name.
    UnknownGroup {
        /// The name.
        got: String,
        /// All names.
        known: Vec<&'static str>,
    },
    /// The group has no function of this name.
    UnknownFunction {
        /// The group.
        group: String,
        /// The name.
        got: String,
        /// All names.
        known: Vec<&'static str>,
    },
    /// A value is not there.
    Missing {
        /// Path of the value.
        path: String,
    },
    /// A value is not what it must be.
    Unexpected {
        /// Path of the value.
        path: String,
        /// What it must be.
        expected: String,
    },
    /// The library refuses a value.
    Refused {
        /// Path of the values.
        path: String,
        /// Why.
        reason: String,
    },
}

impl fmt::Display for EvaluateError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Unreadable(message) => write!(f, "it cannot be read: {message}"),
            Self::Malformed { message, .. } => write!(f, "it is not JSON: {message}"),
            Self::UnknownGroup { got, known } => {
                write!(f, "there is no group {got:?}, only {}", known.join(", "))
            }
            Self::UnknownFunction { group, got, known } => write!(
                f,
                "group {group} has no function {got:?}, only {}",
                known.join(", ")
            ),
            Self::Missing { path } => write!(f, "{path} is missing"),
            Self::Unexpected { path, expected } => write!(f, "{path} must be {expected}"),
            Self::Refused { path, reason } => write!(f, "{path} is refused: {reason}"),
        }
    }
}

impl std::error::Error for EvaluateError {}
