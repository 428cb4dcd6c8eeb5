//! Checks values that a person writes against their bounds, and describes a value that is out of
//! bounds.

use std::fmt;

/// Errors in a scenario file.
#[derive(Clone, Debug, PartialEq)]
pub enum Problem {
    /// The file cannot be read.
    Unreadable(String),
    /// The file is empty.
    Empty,
    /// The file is not TOML, or a key is unknown, missing or of the wrong type.
    Malformed {
        /// The key that the message refers to, if there is one.
        key: Option<String>,
        /// Message of the parser.
        message: String,
    },
    /// The value is NaN or infinite.
    NotFinite {
        /// Path of the key.
        key: String,
        /// The value.
        got: f64,
    },
    /// The value is below its lower bound.
    BelowLeast {
        /// Path of the key.
        key: String,
        /// The value.
        got: f64,
        /// The bound.
        least: f64,
        /// Unit of the bound, with the reason for the bound if that is not obvious.
        unit: &'static str,
    },
    /// The value is above its upper bound.
    AboveMost {
        /// Path of the key.
        key: String,
        /// The value.
        got: f64,
        /// The bound.
        most: f64,
        /// Unit of the bound, with the reason for the bound if that is not obvious.
        unit: &'static str,
    },
    /// The value contradicts another value, or has no effect.
    Contradiction {
        /// Path of the key.
        key: String,
        /// Text that completes the sentence after the key.
        why: &'static str,
    },
}

impl std::error::Error for Problem {}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(why) => write!(f, "cannot be read: {why}"),
            Self::Empty => write!(
                f,
                "is empty; scenarios/flat.toml shows the minimum that a scenario needs"
            ),
            Self::Malformed {
                key: Some(key),
                message,
            } => write!(f, "{key}: {message}"),
            Self::Malformed { key: None, message } => write!(f, "{message}"),
            Self::NotFinite { key, got } => write!(f, "{key} is {got}; it must be a finite number"),
            Self::BelowLeast {
                key,
                got,
                least,
                unit,
            } => {
                write!(
                    f,
                    "{key} is {got}; it must be at least {}",
                    quantity(*least, unit)
                )
            }
            Self::AboveMost {
                key,
                got,
                most,
                unit,
            } => {
                write!(
                    f,
                    "{key} is {got}; it must be at most {}",
                    quantity(*most, unit)
                )
            }
            Self::Contradiction { key, why } => write!(f, "{key} {why}"),
        }
    }
}

/// Formats `value` with its unit. Rounds it to a millionth, so that a computed bound does not show
/// its binary fraction.
fn quantity(value: f64, unit: &str) -> String {
    let space = if unit.is_empty() { "" } else { " " };
    format!("{}{space}{unit}", (value * 1e6).round() / 1e6)
}

impl Problem {
    /// Path of the invalid key, if the problem has one.
    pub fn key(&self) -> Option<&str> {
        match self {
            Self::NotFinite { key, .. }
            | Self::BelowLeast { key, .. }
            | Self::AboveMost { key, .. }
            | Self::Contradiction { key, .. } => Some(key),
            Self::Malformed { key, .. } => key.as_deref(),
            Self::Unreadable(_) | Self::Empty => None,
        }
    }
}

/// Checks that a value is within its bounds, inclusive.
///
/// # Errors
/// [`Problem`] with key, value and bound. NaN and infinity have their own variant, which names no
/// bound.
pub fn within(
    key: &str,
    got: f64,
    least: f64,
    most: f64,
    unit: &'static str,
) -> Result<(), Problem> {
    let key = || key.to_owned();
    if !got.is_finite() {
        Err(Problem::NotFinite { key: key(), got })
    } else if got < least {
        Err(Problem::BelowLeast {
            key: key(),
            got,
            least,
            unit,
        })
    } else if got > most {
        Err(Problem::AboveMost {
            key: key(),
            got,
            most,
            unit,
        })
    } else {
        Ok(())
    }
}

/// Reports that a value is invalid for another reason than its bounds.
///
/// # Errors
/// Always returns [`Problem::Contradiction`].
pub fn contradiction(key: &str, why: &'static str) -> Result<(), Problem> {
    Err(Problem::Contradiction {
        key: key.to_owned(),
        why,
    })
}
