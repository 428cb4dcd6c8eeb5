//! Objects of the settings: their values (0x2200 to 0x22FF), saving (0x1010), restoring (0x1011),
//! and what was found in flash (0x2020).

use crate::bus::node::{Abort, Address, Value, number};
use crate::settings::{FIRST_OBJECT, Setting, SettingError};
use crate::store::{Refused, SCHEMA, State, StoreError};

const SAVE: u16 = 0x1010;
const RESTORE: u16 = 0x1011;
const IN_FLASH: u16 = 0x2020;
/// The letters "save" and "load", as values of an object.
const SAVE_SIGNATURE: u32 = u32::from_le_bytes(*b"save");
const LOAD_SIGNATURE: u32 = u32::from_le_bytes(*b"load");
/// Bit 0: the node saves on command, not by itself.
const ON_COMMAND: u32 = 1;

/// Code of object 0x2020:1 for flash that cannot be read.
pub const UNREADABLE: u8 = 5;

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
    /// The node would not start with these settings, or it has not started.
    Unusable,
    /// The store failed.
    Store(StoreError),
}

/// The settings that clients read and change, and the flash that keeps them.
pub trait Store {
    /// Returns the value of the setting with this key.
    fn value(&self, key: u16) -> Option<i32>;
    /// Changes a setting, for the next save. `live`: the node uses the value at once.
    ///
    /// # Errors
    /// [`SettingError`]; nothing is changed.
    fn set(&mut self, key: u16, value: i32, live: bool) -> Result<(), SettingError>;
    /// Saves the settings, with the changes of clients, and verifies them. The node does nothing
    /// else meanwhile.
    ///
    /// # Errors
    /// [`SaveError`]; all settings in flash have their old or all their new values.
    fn save(&mut self) -> Result<(), SaveError>;
    /// Makes the node blank from its next start on.
    ///
    /// # Errors
    /// [`SaveError`].
    fn clear(&mut self) -> Result<(), SaveError>;
    /// Returns what was found in flash at start.
    fn found(&self) -> Found;
    /// Whether a setting was changed since the start that the node does not use before a restart.
    fn restart_needed(&self) -> bool;
    /// Whether the node started with no settings besides its node id, or with settings that are
    /// not whole ([`Found::is_whole`]).
    fn unconfigured(&self) -> bool;
}

/// Whether this is an object of the settings.
pub(super) fn serves(index: u16) -> bool {
    matches!(index, SAVE | RESTORE | IN_FLASH) || index & 0xff00 == FIRST_OBJECT
}

/// Reads an object of the settings.
///
/// # Errors
/// [`Abort`].
pub(super) fn read(store: &impl Store, address: Address) -> Result<Value, Abort> {
    let Address { index, sub } = address;
    match (index, sub) {
        (SAVE | RESTORE, 0) => Ok(Value::new(1, 1)), // highest sub-index
        (SAVE | RESTORE, 1) => Ok(Value::new(ON_COMMAND, 4)),
        (SAVE | RESTORE, _) => Err(Abort::NoSubIndex),
        (IN_FLASH, _) => in_flash(store, sub).ok_or(Abort::NoSubIndex),
        _ => {
            let value = store.value(index - FIRST_OBJECT).ok_or(Abort::NoObject)?;
            match sub {
                0 => Ok(Value::new(value as u32, 4)),
                _ => Err(Abort::NoSubIndex),
            }
        }
    }
}

fn in_flash(store: &impl Store, sub: u8) -> Option<Value> {
    let found = store.found();
    let (key, value) = found
        .refused
        .map_or((0, 0), |refused| (refused.key, refused.got));
    let (number, length) = match sub {
        0 => (7, 1), // highest sub-index
        1 => (found.state.into(), 1),
        2 => (found.schema.into(), 2),
        3 => (SCHEMA.version.into(), 2),
        4 => (found.refusals.into(), 2),
        5 => (key.into(), 2),
        6 => (value as u32, 4),
        7 => (store.restart_needed().into(), 1),
        _ => return None,
    };
    Some(Value::new(number, length))
}

/// Returns the setting that this object is.
pub(super) fn setting(address: Address) -> Option<Setting> {
    let key = address.index.wrapping_sub(FIRST_OBJECT);
    (address.sub == 0).then(|| Setting::from_key(key)).flatten()
}

/// Writes an object of the settings. An `armed` node does not write its flash: that stops the
/// processor for longer than the current loop may pause. `live`: the node uses the setting at once.
///
/// # Errors
/// [`Abort`].
pub(super) fn write(
    store: &mut impl Store,
    address: Address,
    value: &[u8],
    armed: bool,
    live: bool,
) -> Result<(), Abort> {
    let Address { index, sub } = address;
    let value = number(value);
    match (index, sub) {
        (SAVE | RESTORE, 0) | (IN_FLASH, _) => Err(Abort::ReadOnly),
        (SAVE, 1) if value == SAVE_SIGNATURE && !armed => store.save().map_err(refused),
        (RESTORE, 1) if value == LOAD_SIGNATURE && !armed => store.clear().map_err(refused),
        (SAVE, 1) if value == SAVE_SIGNATURE => Err(Abort::DeviceState),
        (RESTORE, 1) if value == LOAD_SIGNATURE => Err(Abort::DeviceState),
        (SAVE | RESTORE, 1) => Err(Abort::NotStored),
        (SAVE | RESTORE, _) => Err(Abort::NoSubIndex),
        (_, 0) => {
            let set = store.set(index - FIRST_OBJECT, value as i32, live);
            set.map_err(|error| match error {
                SettingError::UnknownKey(_) => Abort::NoObject,
                SettingError::OutOfRange { setting, got } if got < setting.bounds().minimum => {
                    Abort::TooLow
                }
                SettingError::OutOfRange { .. } => Abort::TooHigh,
            })
        }
        _ => Err(Abort::NoSubIndex),
    }
}

fn refused(error: SaveError) -> Abort {
    match error {
        SaveError::Unusable => Abort::Incompatible,
        SaveError::Store(_) => Abort::Hardware,
    }
}
