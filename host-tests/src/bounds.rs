//! Bounds of values that a person writes, and what is said about a bad one.

use std::fmt;

/// Ways in which a scenario can be bad.
#[derive(Clone, Debug, PartialEq)]
pub enum Problem {
    /// The file cannot be read.
    Unreadable(String),
    /// There is nothing in it.
    Empty,
    /// It is not TOML, or a key is unknown, missing or of the wrong type.
    Malformed {
        /// The key whose value it is, if there is one.
        key: Option<String>,
        /// What the parser says.
        message: String,
    },
    /// A NaN or an infinity.
    NotFinite {
        /// Path of the key.
        key: String,
        /// The value.
        got: f64,
    },
    /// Below its lower bound.
    BelowLeast {
        /// Path of the key.
        key: String,
        /// The value.
        got: f64,
        /// The bound.
        least: f64,
        /// Unit, and the bound's reason where it is not plain.
        unit: &'static str,
    },
    /// Above its upper bound.
    AboveMost {
        /// Path of the key.
        key: String,
        /// The value.
        got: f64,
        /// The bound.
        most: f64,
        /// Unit, and the bound's reason where it is not plain.
        unit: &'static str,
    },
    /// At odds with another value, or without effect.
    Contradiction {
        /// Path of the key.
        key: String,
        /// The rest of the sentence.
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
                "is empty; scenarios/flat.toml shows the least that a scenario needs"
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

/// Rounded to a micro-unit, so that a computed bound does not show its binary fraction.
fn quantity(value: f64, unit: &str) -> String {
    let space = if unit.is_empty() { "" } else { " " };
    format!("{}{space}{unit}", (value * 1e6).round() / 1e6)
}

impl Problem {
    /// Path of the key that is bad, if there is one.
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

/// Whether a value is within its bounds, which are allowed. A NaN or infinity is told apart, because
/// its bound is not the point.
///
/// # Errors
/// Names key, value and bound.
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

/// What is wrong with a value beside its bounds.
///
/// # Errors
/// Always.
pub fn contradiction(key: &str, why: &'static str) -> Result<(), Problem> {
    Err(Problem::Contradiction {
        key: key.to_owned(),
        why,
    })
}
