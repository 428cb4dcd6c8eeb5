//! The node's settings: those in flash, and those that clients read and change.
//!
//! The tasks get the settings once, at start. A change by a client takes effect after a save and a
//! restart.

use crate::boards::{Board, Selected};
use crate::roles::Refusal;
use core::cell::RefCell;
use critical_section::Mutex;
use static_cell::StaticCell;
use tautrack::roles::settings::{Found, SaveError, UNREADABLE};
use tautrack::settings::{SettingError, Settings};
use tautrack::store::{Report, SCHEMA, State, Store, StoreError};

/// Returns a [`Refusal`] if the node would not start with these settings.
pub type Check = fn(&Settings) -> Result<(), Refusal>;

struct Shared {
    /// The settings with the changes of clients.
    edited: &'static mut Settings,
    found: Found,
    unconfigured: bool,
    changed: bool,
    /// Bits of the keys that clients have set.
    set: [u32; 8],
    check: Check,
}

static SHARED: Mutex<RefCell<Option<Shared>>> = Mutex::new(RefCell::new(None));

/// Loads the settings from flash. Returns them with what was found. The board calls it once, at
/// start.
#[inline(never)] // its stack is free again when the node starts
pub fn load() -> (Settings, Found) {
    let mut settings = Settings::default();
    let report = Store::open(Selected::storage()).and_then(|mut store| {
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

/// Makes `settings`, with which the node starts, those that clients read and change. They are saved
/// only if `check` accepts them.
#[inline(never)] // its stack is free again when the tasks start
pub fn publish(settings: &Settings, found: Found, check: Check) {
    static EDITED: StaticCell<Settings> = StaticCell::new();
    // Compares all settings, so it is done before interrupts are masked.
    let unconfigured = settings.is_unconfigured() || !found.is_whole();
    if let Some(edited) = EDITED.try_init_with(|| settings.clone()) {
        critical_section::with(|cs| {
            SHARED.borrow(cs).replace(Some(Shared {
                edited,
                found,
                unconfigured,
                changed: false,
                set: [0; 8],
                check,
            }));
        });
    }
}

fn with<R>(body: impl FnOnce(&mut Shared) -> R) -> Option<R> {
    critical_section::with(|cs| SHARED.borrow(cs).borrow_mut().as_mut().map(body))
}

/// The settings that clients read and change, and the flash that keeps them.
pub struct Flash;

impl tautrack::roles::settings::Store for Flash {
    fn value(&self, key: u16) -> Option<i32> {
        with(|shared| shared.edited.of_key(key)).flatten()
    }

    fn set(&mut self, key: u16, value: i32) -> Result<(), SettingError> {
        with(|shared| {
            let old = shared.edited.of_key(key);
            shared.edited.set(key, value)?;
            shared.changed |= old != Some(value);
            if let Some(word) = shared.set.get_mut(usize::from(key / 32)) {
                *word |= 1 << (key % 32);
            }
            Ok(())
        })
        .unwrap_or(Err(SettingError::UnknownKey(key)))
    }

    fn save(&mut self) -> Result<(), SaveError> {
        save_edited()
    }

    fn clear(&mut self) -> Result<(), SaveError> {
        let cleared = Store::open(Selected::storage()).and_then(|mut store| store.clear());
        with(|shared| shared.changed = true);
        cleared.map_err(SaveError::Store)
    }

    fn found(&self) -> Found {
        with(|shared| shared.found).unwrap_or_default()
    }

    fn restart_needed(&self) -> bool {
        with(|shared| shared.changed).unwrap_or_default()
    }

    fn unconfigured(&self) -> bool {
        with(|shared| shared.unconfigured).unwrap_or(true)
    }
}

fn save_edited() -> Result<(), SaveError> {
    let shared = with(|shared| (shared.edited.clone(), shared.set, shared.check));
    let Some((edited, set, check)) = shared else {
        return Err(SaveError::Unusable);
    };
    if let Err(refusal) = check(&edited) {
        crate::logger::error!("settings are not saved: {}", crate::roles::text(&refusal));
        return Err(SaveError::Unusable);
    }
    let is_set = |key: u16| {
        let word = set.get(usize::from(key / 32)).copied();
        word.unwrap_or_default() >> (key % 32) & 1 != 0
    };
    write(&edited, &is_set).map_err(SaveError::Store)
}

/// Writes the first settings of a node to flash and verifies them. Erases flash that cannot be
/// read.
///
/// # Errors
/// [`StoreError`].
pub fn create(settings: &Settings) -> Result<(), StoreError> {
    match write(settings, &|_| true) {
        Err(StoreError::Damaged | StoreError::TooManyKeys { .. }) => {
            Store::open(Selected::storage())?.clear()?;
            write(settings, &|_| true)
        }
        written => written,
    }
}

fn write(settings: &Settings, is_set: &dyn Fn(u16) -> bool) -> Result<(), StoreError> {
    let mut store = Store::open(Selected::storage())?;
    let value = |key| settings.of_key(key).unwrap_or_default();
    let saved = store.save(&SCHEMA, &value, is_set).map(|_| ());
    if let Err(error) = saved {
        crate::logger::error!("settings were not saved: {}", code(error));
    }
    saved
}

/// Word for the log.
fn code(error: StoreError) -> &'static str {
    match error {
        StoreError::UnsuitableFlash => "unsuitable flash",
        StoreError::Flash(_) => "the flash refused an access",
        StoreError::Full => "the flash is full",
        StoreError::Damaged => "the flash is damaged",
        StoreError::NotVerified { .. } => "a value was not written",
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
