//! What a program knows of the settings in flash.

use crate::settings::{BOUNDS, Bounds, SCHEMA_VERSION};

/// The settings that a program knows.
///
/// A key never changes its meaning. If a setting gets another unit or meaning, it gets a new key
/// and a [`Move`], and the [version](Self::version) rises.
#[derive(Clone, Copy, Debug)]
pub struct Schema<'a> {
    /// Version, from 1.
    pub version: u16,
    /// The settings; no key is `0xffff`.
    pub rows: &'a [Bounds],
    /// Settings that replace others, oldest first.
    pub moves: &'a [Move],
}

/// The schema of this program.
pub const SCHEMA: Schema<'static> = Schema {
    version: SCHEMA_VERSION,
    rows: BOUNDS,
    moves: &[],
};

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
