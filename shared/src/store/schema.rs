//! What a program knows of the settings in flash.

use crate::settings::{BOUNDS, Bounds, SCHEMA_VERSION, Setting};

/// The settings that a program knows.
///
/// A key never changes its meaning. If a setting gets another unit or meaning, it gets a new key
/// and a [`Move`], and the [version](Self::version) rises.
#[derive(Clone, Copy, Debug)]
pub struct Schema<'a> {
    /// Version, from 1.
    pub version: u16,
    /// The settings; keys below [`Record::FIRST_KEY`], and not 0.
    pub rows: &'a [Bounds],
    /// Groups of settings that change together.
    pub records: &'a [Record],
    /// Settings that replace others, oldest first. None belongs to a record.
    pub moves: &'a [Move],
}

/// The schema of this program.
pub const SCHEMA: Schema<'static> = Schema {
    version: SCHEMA_VERSION,
    rows: BOUNDS,
    records: RECORDS,
    moves: &[],
};

/// Group of settings that make sense only together, such as the results of a calibration. Flash
/// holds all new values of a group or all old ones.
#[derive(Clone, Copy, Debug)]
pub struct Record {
    /// Key of the group in flash.
    pub key: u16,
    /// Its settings, at most [`Record::MAX_SETTINGS`]. A group that is in use never loses one.
    pub settings: &'static [Setting],
}

impl Record {
    /// First key of a group; settings have lower ones.
    pub const FIRST_KEY: u16 = 0x8000;
    /// Maximum number of settings in a group.
    pub const MAX_SETTINGS: usize = 8;
}

/// The groups of the settings in [`BOUNDS`].
pub const RECORDS: &[Record] = &[
    // Alignment of the rotor sensor with the windings.
    Record {
        key: 0x8001,
        settings: &[
            Setting::PolePairs,
            Setting::ElectricalOffset,
            Setting::PhaseOrder,
        ],
    },
    // Calibration of the magnetometer.
    Record {
        key: 0x8002,
        settings: &[
            Setting::HardIronForward,
            Setting::HardIronLeft,
            Setting::HardIronUp,
        ],
    },
    // Measured motor: the current loop is computed from these.
    Record {
        key: 0x8003,
        settings: &[
            Setting::Resistance,
            Setting::Inductance,
            Setting::InductanceQ,
        ],
    },
];

/// Replaces one setting by another from a schema version on.
///
/// A program with the new schema also keeps the old key up to date, so that a downgrade finds its
/// value. [`up`](Self::up) undoes [`down`](Self::down).
#[derive(Clone, Copy, Debug)]
pub struct Move {
    /// First schema version with the new key.
    pub since: u16,
    /// Key of earlier versions.
    pub old: u16,
    /// Key from this version on.
    pub new: u16,
    /// Converts a value of the old key.
    pub up: fn(i32) -> i32,
    /// Converts a value of the new key.
    pub down: fn(i32) -> i32,
}
