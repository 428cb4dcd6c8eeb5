//! What a program knows of the settings in flash.

use crate::settings::{Bounds, SCHEMA_VERSION, bounds_of_row};

/// The settings that a program knows.
///
/// A key never changes its meaning. If a setting gets another unit or meaning, it gets a new key
/// and a [`Move`], and the [version](Self::version) rises.
#[derive(Clone, Copy)]
#[allow(missing_debug_implementations)] // a function has none
pub struct Schema<'a> {
    /// Version, from 1.
    pub version: u16,
    /// Returns the setting with this index, counted from 0; no key is `0xffff`.
    pub row: &'a dyn Fn(usize) -> Option<Bounds>,
    /// Settings that replace others, oldest first.
    pub moves: &'a [Move],
}

impl Schema<'_> {
    /// Returns the settings.
    pub fn rows(&self) -> impl Iterator<Item = Bounds> {
        (0..).map_while(self.row)
    }
}

/// The schema of this program.
pub const SCHEMA: Schema<'static> = Schema {
    version: SCHEMA_VERSION,
    row: &bounds_of_row,
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
