//! Result of loading the settings.

use core::fmt;
use heapless::Vec;

/// Maximum number of refused values that a [`Report`] lists.
const MAX_LISTED: usize = 4;

/// State of the settings in flash at start. The number is the code of each state on the bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum State {
    /// Nothing is stored. Every setting has its default.
    Blank = 0,
    /// Everything was loaded.
    Loaded = 1,
    /// The settings come from another schema version, and were converted.
    Migrated = 2,
    /// A power cut interrupted a save, or one of the two copies is damaged. The settings are those
    /// of the whole copy, which may be the earlier one.
    Repaired = 3,
    /// Some values were out of bounds. These settings have their defaults.
    PartlyRefused = 4,
}

/// Value in flash that is out of the bounds of its setting.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Refused {
    /// Key of the setting.
    pub key: u16,
    /// Value in flash.
    pub got: i32,
    /// Smallest value of the setting.
    pub minimum: i32,
    /// Largest value of the setting.
    pub maximum: i32,
}

/// Result of loading the settings.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Report {
    /// Schema version in flash; `None` if nothing is stored.
    pub stored: Option<u16>,
    /// Whether this version is not the program's.
    pub migrated: bool,
    /// Whether one of the two copies in flash is damaged.
    pub repaired: bool,
    /// Number of refused values.
    pub refusals: usize,
    /// The first refused values.
    pub refused: Vec<Refused, MAX_LISTED>,
}

impl Report {
    /// The state that a person must know first.
    pub fn state(&self) -> State {
        match self {
            Self { stored: None, .. } => State::Blank,
            Self { refusals: 1.., .. } => State::PartlyRefused,
            Self { repaired: true, .. } => State::Repaired,
            Self { migrated: true, .. } => State::Migrated,
            _ => State::Loaded,
        }
    }

    pub(super) fn refuse(&mut self, refused: Refused) {
        self.refusals += 1;
        let _ = self.refused.push(refused); // what does not fit is counted
    }
}

impl fmt::Display for Report {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(stored) = self.stored else {
            return write!(out, "blank");
        };
        write!(out, "schema {stored}")?;
        if self.migrated {
            write!(out, ", converted")?;
        }
        if self.repaired {
            write!(out, ", a save was interrupted or a copy is damaged")?;
        }
        for refused in &self.refused {
            let Refused {
                key,
                got,
                minimum,
                maximum,
            } = refused;
            write!(
                out,
                ", {key:#06x} = {got} refused, allowed {minimum} to {maximum}"
            )?;
        }
        Ok(())
    }
}
