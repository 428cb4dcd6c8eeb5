//! Errors in a document, with their place.

use std::fmt;

/// An error in a document; displays as one sentence.
#[derive(Clone, Debug, PartialEq)]
pub enum EvaluateError {
    /// The document cannot be read.
    Unreadable(String),
    /// The document is not JSON.
    Malformed {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The parser's message, with the place.
        message: String,
    },
    /// No group has this name.
    UnknownGroup {
        /// The name in the document.
        got: String,
        /// Names of all groups.
        known: Vec<&'static str>,
    },
    /// The group has no function of this name.
    UnknownFunction {
        /// The group.
        group: String,
        /// The name in the document.
        got: String,
        /// Names of all functions of the group.
        known: Vec<&'static str>,
    },
    /// A value is missing.
    Missing {
        /// Path of the value.
        path: String,
    },
    /// A value has the wrong type or length.
    Unexpected {
        /// Path of the value.
        path: String,
        /// The expected type or length.
        expected: String,
    },
    /// The library does not accept a value.
    Refused {
        /// Path of the values.
        path: String,
        /// The reason.
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
