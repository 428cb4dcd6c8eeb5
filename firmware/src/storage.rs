//! The node's settings: those in flash, and those that clients read and change.
//!
//! The node gets the settings at start. A change by a client takes effect at once or after a save
//! and a restart, as the table of the settings says.

use crate::boards::LIMITS;
use crate::refusal::{self, Refusal};
use embedded_storage::nor_flash::NorFlash;
use tautrack::motor::board_limits;
use tautrack::roles::settings::{Found, SaveError, UNREADABLE};
use tautrack::settings::{Setting, SettingError, Settings, UNKNOWN_MOTOR};
use tautrack::store::{self, Report, Schema, State, Store, StoreError};

/// What the program knows of the settings, with the defaults of the board.
const SCHEMA: Schema<'static> = Schema {
    row: &|index| board_limits::row(LIMITS, index),
    ..store::SCHEMA
};

/// Returns a [`Refusal`] if the node would not start with these settings.
pub type Check = fn(&Settings) -> Result<(), Refusal>;

/// Loads the settings from flash. Returns them with what was found.
#[inline(never)] // its stack is free again when the node starts
pub fn load(flash: &mut impl NorFlash) -> (Settings, Found) {
    let mut settings = Settings::default();
    board_limits::set_defaults(LIMITS, &mut settings);
    let report = Store::open(flash).and_then(|mut store| {
        store.load(&SCHEMA, &mut |key, value| {
            // Cannot fail: the store has checked the bounds.
            let _ = settings.set(key, value);
        })
    });
    let found = match report {
        Ok(report) => found(&report),
        Err(error) => {
            crate::logger::error!("settings in flash cannot be read: {}", code(error));
            Found {
                state: UNREADABLE,
                ..Found::default()
            }
        }
    };
    (settings, found)
}

fn found(report: &Report) -> Found {
    let state = report.state();
    if state != State::Blank {
        crate::logger::info!(
            "settings from flash: state {}, schema {}",
            state as u8,
            report.stored.unwrap_or_default()
        );
    }
    for refused in &report.refused {
        crate::logger::warn!(
            "setting {:#06x} = {} in flash is refused, allowed {} to {}",
            refused.key,
            refused.got,
            refused.minimum,
            refused.maximum
        );
    }
    Found {
        state: state as u8,
        schema: report.stored.unwrap_or_default(),
        refusals: report.refusals as u16,
        refused: report.refused.first().copied(),
    }
}

/// The settings that clients read and change, and the flash that keeps them.
pub struct Storage<F> {
    flash: F,
    /// The settings with the changes of clients.
    edited: Settings,
    found: Found,
    unconfigured: bool,
    changed: bool,
    /// Bits of the keys that clients have set.
    set: [u32; 8],
    check: Check,
}

impl<F: NorFlash> Storage<F> {
    /// The settings with which the node starts, and what was found in `flash`. Changes are saved
    /// only if `check` accepts them.
    pub fn new(settings: &Settings, found: Found, check: Check, flash: F) -> Self {
        Self {
            flash,
            unconfigured: settings.is_unconfigured() || !found.is_whole(),
            edited: settings.clone(),
            found,
            changed: false,
            set: [0; 8],
            check,
        }
    }
}

impl<F: NorFlash> tautrack::roles::settings::Store for Storage<F> {
    fn value(&self, key: u16) -> Option<i32> {
        self.edited.of_key(key)
    }

    fn set(&mut self, key: u16, value: i32, live: bool) -> Result<(), SettingError> {
        let old = self.edited.of_key(key);
        self.edited.set(key, value)?;
        self.changed |= old != Some(value) && !live;
        if let Some(word) = self.set.get_mut(usize::from(key / 32)) {
            *word |= 1 << (key % 32);
        }
        Ok(())
    }

    fn save(&mut self) -> Result<(), SaveError> {
        if let Err(refusal) = (self.check)(&self.edited) {
            crate::logger::error!("settings are not saved: {}", refusal::text(&refusal));
            return Err(SaveError::Unusable);
        }
        let set = &self.set;
        let is_set = |key: u16| {
            let word = set.get(usize::from(key / 32)).copied();
            word.unwrap_or_default() >> (key % 32) & 1 != 0
        };
        write(&mut self.flash, &self.edited, &is_set).map_err(SaveError::Store)
    }

    fn clear(&mut self) -> Result<(), SaveError> {
        self.changed = true;
        Store::open(&mut self.flash)
            .and_then(|mut store| store.clear())
            .map_err(SaveError::Store)
    }

    fn found(&self) -> Found {
        self.found
    }

    fn restart_needed(&self) -> bool {
        self.changed
    }

    fn unconfigured(&self) -> bool {
        self.unconfigured
    }
}

/// Writes the first settings of a node to flash and verifies them. Erases flash that cannot be
/// read.
///
/// # Errors
/// [`StoreError`].
pub fn create(flash: &mut impl NorFlash, settings: &Settings) -> Result<(), StoreError> {
    match write(flash, settings, &|_| true) {
        Err(StoreError::TooManyKeys { .. }) => {
            Store::open(&mut *flash)?.clear()?;
            write(flash, settings, &|_| true)
        }
        written => written,
    }
}

fn write(
    flash: &mut impl NorFlash,
    settings: &Settings,
    is_set: &dyn Fn(u16) -> bool,
) -> Result<(), StoreError> {
    let mut store = Store::open(flash)?;
    let value = |key| settings.of_key(key).unwrap_or_default();
    let saved = store.save(&SCHEMA, &value, is_set).map(|_| ());
    if let Err(error) = saved {
        crate::logger::error!("settings were not saved: {}", code(error));
    }
    saved
}

/// The board's defaults with this node id, and with limits that suit an unknown motor.
pub fn with_id(id: u8) -> Settings {
    let mut settings = Settings::default();
    board_limits::set_defaults(LIMITS, &mut settings);
    let mut set = |setting: Setting, value: i32| {
        // Cannot fail: the master's request was checked, and the limits are within their bounds.
        let _ = settings.set(setting.bounds().key, value);
    };
    set(Setting::NodeId, id.into());
    for (setting, value) in UNKNOWN_MOTOR {
        set(*setting, *value);
    }
    settings
}

/// Word for the log.
fn code(error: StoreError) -> &'static str {
    match error {
        StoreError::UnsuitableFlash => "unsuitable flash",
        StoreError::Flash(_) => "the flash refused an access",
        StoreError::Full => "the flash is full",
        StoreError::Damaged => "the flash is damaged",
        StoreError::NotVerified => "what was written is not there",
        StoreError::TooManyKeys { .. } => "too many keys",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A set of old and new values may be a gear ratio without its encoder.
    #[test]
    fn settings_are_whole_unless_some_are_refused_or_their_save_was_interrupted() {
        let report = |repaired, refusals| Report {
            stored: Some(1),
            repaired,
            refusals,
            ..Report::default()
        };
        for (repaired, refusals, whole) in [
            (false, 0, true),
            (true, 0, false),
            (false, 1, false),
            (true, 1, false),
        ] {
            assert_eq!(found(&report(repaired, refusals)).is_whole(), whole);
        }
    }
}
