//! SDO server of the settings: their objects, saving (0x1010), restoring (0x1011), and what was
//! found in flash (0x2020).
//!
//! These objects are not in the dictionary, which would need a static object for each setting and
//! checks no bounds.

use super::filter::{DEVICE_STATE, PARAMETER_LENGTH, SDO_REQUEST, SDO_RESPONSE, VALUE_TOO_HIGH};
use crate::storage::{self, SaveError};
use tautrack::can::Frame;
use tautrack::settings::{FIRST_OBJECT, SettingError};
use tautrack::store::SCHEMA;

const SAVE: u16 = 0x1010;
const RESTORE: u16 = 0x1011;
const IN_FLASH: u16 = 0x2020;
/// The letters "save" and "load", as values of an object.
const SAVE_SIGNATURE: u32 = u32::from_le_bytes(*b"save");
const LOAD_SIGNATURE: u32 = u32::from_le_bytes(*b"load");
/// Bit 0: the node saves on command, not by itself.
const ON_COMMAND: u32 = 1;

/// Abort codes of CiA 301.
const HARDWARE: u32 = 0x0606_0000;
const NO_OBJECT: u32 = 0x0602_0000;
const NO_SUB_INDEX: u32 = 0x0609_0011;
const VALUE_TOO_LOW: u32 = 0x0609_0032;
const READ_ONLY: u32 = 0x0601_0002;
const NOT_STORED: u32 = 0x0800_0020;
const INCOMPATIBLE: u32 = 0x0604_0043;

/// Value that an SDO transfers, with its number of bytes.
type Value = (u32, u8);

/// Answers an SDO request to node `node_id` that concerns settings. Returns `None` for every other
/// frame.
pub fn answer(frame: &Frame, node_id: u8) -> Option<Frame> {
    let &[command, low, high, sub, a, b, c, d] = frame.data() else {
        return None;
    };
    let index = u16::from_le_bytes([low, high]);
    let own = frame.id() == SDO_REQUEST + u16::from(node_id);
    let served = matches!(index, SAVE | RESTORE | IN_FLASH) || index & 0xff00 == FIRST_OBJECT;
    let result = match command >> 5 {
        _ if !own || !served => return None,
        1 => {
            // Expedited transfers of four bytes, whose size may be given or not.
            let four = matches!(command & 0x1f, 0x02 | 0x03);
            let written = if four {
                write(index, sub, u32::from_le_bytes([a, b, c, d]))
            } else {
                Err(PARAMETER_LENGTH)
            };
            written.map(|()| None)
        }
        2 => read(index, sub).map(Some),
        _ => return None,
    };
    let (command, value) = match result {
        Ok(None) => (0x60, 0),
        Ok(Some((value, bytes))) => (0x43 | (4 - bytes) << 2, value),
        Err(abort) => (0x80, abort),
    };
    let [a, b, c, d] = value.to_le_bytes();
    Frame::new(
        SDO_RESPONSE + u16::from(node_id),
        &[command, low, high, sub, a, b, c, d],
    )
}

fn read(index: u16, sub: u8) -> Result<Value, u32> {
    match (index, sub) {
        (SAVE | RESTORE, 0) => Ok((1, 1)), // highest sub-index
        (SAVE | RESTORE, 1) => Ok((ON_COMMAND, 4)),
        (SAVE | RESTORE, _) => Err(NO_SUB_INDEX),
        (IN_FLASH, _) => in_flash(sub).ok_or(NO_SUB_INDEX),
        (_, 0) => match storage::value(index - FIRST_OBJECT) {
            Some(value) => Ok((value as u32, 4)),
            None => Err(NO_OBJECT),
        },
        _ => Err(NO_SUB_INDEX),
    }
}

fn in_flash(sub: u8) -> Option<Value> {
    let found = storage::found_at_start();
    let (key, value) = found
        .refused
        .map_or((0, 0), |refused| (refused.key, refused.got));
    Some(match sub {
        0 => (7, 1), // highest sub-index
        1 => (found.state.into(), 1),
        2 => (found.schema.into(), 2),
        3 => (SCHEMA.version.into(), 2),
        4 => (found.refusals.into(), 2),
        5 => (key.into(), 2),
        6 => (value as u32, 4),
        7 => (storage::restart_needed().into(), 1),
        _ => return None,
    })
}

fn write(index: u16, sub: u8, value: u32) -> Result<(), u32> {
    match (index, sub) {
        (SAVE | RESTORE, 0) | (IN_FLASH, _) => Err(READ_ONLY),
        (SAVE, 1) if value == SAVE_SIGNATURE => storage::save().map_err(save_abort),
        (RESTORE, 1) if value == LOAD_SIGNATURE => storage::clear().map_err(save_abort),
        (SAVE | RESTORE, 1) => Err(NOT_STORED),
        (SAVE | RESTORE, _) => Err(NO_SUB_INDEX),
        (_, 0) => storage::set(index - FIRST_OBJECT, value as i32).map_err(|error| match error {
            SettingError::UnknownKey(_) => NO_OBJECT,
            SettingError::OutOfRange { setting, got } if got < setting.bounds().minimum => {
                VALUE_TOO_LOW
            }
            SettingError::OutOfRange { .. } => VALUE_TOO_HIGH,
        }),
        _ => Err(NO_SUB_INDEX),
    }
}

fn save_abort(error: SaveError) -> u32 {
    match error {
        SaveError::Armed => DEVICE_STATE,
        SaveError::Unusable => INCOMPATIBLE,
        SaveError::Store(_) => HARDWARE,
    }
}
