//! The node's settings: those in flash, and those that clients read and change.
//!
//! The tasks get the settings once, at start. A change by a client takes effect after a save and a
//! restart.

use crate::boards::{Board, Selected};
use crate::roles::Refusal;
use core::cell::RefCell;
use core::sync::atomic::{AtomicBool, Ordering};
use critical_section::Mutex;
use static_cell::StaticCell;
use tautrack::bus::scale::UNCONFIGURED;
use tautrack::settings::{SettingError, Settings};
use tautrack::store::{Refused, Report, SCHEMA, State, Store, StoreError};

/// Code of object 0x2020:1 for flash that cannot be read.
const UNREADABLE: u8 = 5;

/// Returns a [`Refusal`] if the node would not start with these settings.
pub type Check = fn(&Settings) -> Result<(), Refusal>;

/// What the node found in flash at start, as object 0x2020 has it.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Found {
    /// Code of the [`State`]; 5 if the flash cannot be read.
    pub state: u8,
    /// Schema version in flash; 0 if nothing was stored.
    pub schema: u16,
    /// Number of refused values.
    pub refusals: u16,
    /// The first refused value.
    pub refused: Option<Refused>,
}

impl Found {
    /// Whether all settings are those that were saved last: none was refused, and no save was
    /// interrupted. The robot is not armed with others.
    pub fn is_whole(&self) -> bool {
        self.refusals == 0 && self.state != State::Repaired as u8
    }

    /// Whether the flash holds settings with which a node may start.
    pub fn has_settings(&self) -> bool {
        self.state != State::Blank as u8 && self.state != UNREADABLE
    }
}

/// Why settings were not saved.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SaveError {
    /// The motor has current, or the robot is armed. Writing flash stops the processor for longer
    /// than the current loop may pause.
    Armed,
    /// The node would not start with these settings, or it has not started.
    Unusable,
    /// The store failed.
    Store(StoreError),
}

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
static ARMED: AtomicBool = AtomicBool::new(false);
static WRITING: AtomicBool = AtomicBool::new(false);

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

/// What was found in flash at start.
pub fn found_at_start() -> Found {
    with(|shared| shared.found).unwrap_or_default()
}

/// Whether a setting was changed since the start.
pub fn restart_needed() -> bool {
    with(|shared| shared.changed).unwrap_or_default()
}

/// Bit of object 0x2010 if the node started with no settings besides its node id, or with settings
/// that are not whole ([`Found::is_whole`]); else 0.
pub fn unconfigured_mark() -> u16 {
    match with(|shared| shared.unconfigured) {
        Some(true) => UNCONFIGURED,
        _ => 0,
    }
}

/// Returns the value of the setting with this key.
pub fn value(key: u16) -> Option<i32> {
    with(|shared| shared.edited.of_key(key)).flatten()
}

/// Changes a setting, for the next save.
///
/// # Errors
/// [`SettingError`]; nothing is changed.
pub fn set(key: u16, value: i32) -> Result<(), SettingError> {
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

/// Records whether flash must not be written now. The control task calls it in each tick.
pub fn set_armed(armed: bool) {
    ARMED.store(armed, Ordering::Relaxed);
}

/// Whether flash is being written. The control task arms no drive meanwhile.
pub fn is_writing() -> bool {
    WRITING.load(Ordering::Relaxed)
}

/// Runs `write`, unless the motor has current. Nothing arms the drive before it has ended: the
/// control task interrupts this one, and either it has seen [`is_writing`] or this task sees that
/// it has armed.
#[inline(never)] // one copy for two callers
fn while_disarmed(write: fn() -> Result<(), SaveError>) -> Result<(), SaveError> {
    WRITING.store(true, Ordering::SeqCst);
    let written = if ARMED.load(Ordering::SeqCst) {
        Err(SaveError::Armed)
    } else {
        write()
    };
    WRITING.store(false, Ordering::SeqCst);
    written
}

/// Saves the settings, with the changes of clients, and verifies them.
///
/// # Errors
/// [`SaveError`]; each setting in flash has its old or its new value.
pub fn save() -> Result<(), SaveError> {
    while_disarmed(save_edited)
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

/// Makes the node blank from its next start on.
///
/// # Errors
/// [`SaveError`].
pub fn clear() -> Result<(), SaveError> {
    while_disarmed(|| {
        let cleared = Store::open(Selected::storage()).and_then(|mut store| store.clear());
        with(|shared| shared.changed = true);
        cleared.map_err(SaveError::Store)
    })
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
