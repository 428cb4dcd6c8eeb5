//! Loads settings from flash and saves them.

use super::copies::{BLOCK, Copies, Found};
use super::image::Image;
use super::{Refused, Report, Schema};
use core::fmt;
use embedded_storage::nor_flash::{NorFlash, NorFlashError, NorFlashErrorKind};

/// Schema version of a store that was cleared.
const BLANK: u16 = 0;

/// Why the store failed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum StoreError {
    /// The flash has fewer than two pages, pages below 64 bytes, or words that are no divisor of
    /// 32 bytes.
    UnsuitableFlash,
    /// The flash refused an access.
    Flash(NorFlashErrorKind),
    /// The flash has no room for a value. Every old value is still there.
    Full,
    /// The flash is not blank, and holds no settings.
    Damaged,
    /// The flash does not hold what was written.
    NotVerified,
    /// More keys than the program can read.
    TooManyKeys {
        /// The maximum number.
        maximum: usize,
    },
}

impl fmt::Display for StoreError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnsuitableFlash => {
                write!(out, "the flash has too few pages, or unsuitable words")
            }
            Self::Flash(kind) => write!(out, "the flash refused an access: {kind:?}"),
            Self::Full => write!(out, "the flash is full"),
            Self::Damaged => write!(out, "the flash holds no settings that can be read"),
            Self::NotVerified => write!(out, "the flash does not hold what was written"),
            Self::TooManyKeys { maximum } => write!(out, "more than {maximum} keys in flash"),
        }
    }
}

impl<E: NorFlashError> From<E> for StoreError {
    fn from(error: E) -> Self {
        Self::Flash(error.kind())
    }
}

/// Result of a save.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Saved {
    /// Number of settings that flash did not hold before.
    pub changed: usize,
}

/// The settings in one area of flash, which consists of at least two pages.
///
/// A power cut at any time leaves all settings with their old or all with their new values. Keys
/// that the program does not know stay in flash.
pub struct Store<F> {
    copies: Copies<F>,
}

impl<F: NorFlash> Store<F> {
    /// Opens the store in the whole of `flash`.
    ///
    /// # Errors
    /// [`StoreError::UnsuitableFlash`].
    pub fn open(flash: F) -> Result<Self, StoreError> {
        let words_fit = BLOCK.is_multiple_of(F::WRITE_SIZE) && F::ERASE_SIZE >= 2 * BLOCK;
        if !words_fit || flash.capacity() < 2 * F::ERASE_SIZE {
            return Err(StoreError::UnsuitableFlash);
        }
        let copies = Copies { flash };
        Ok(Self { copies })
    }

    /// Gives the flash back.
    pub fn into_inner(self) -> F {
        self.copies.flash
    }

    /// Reads all settings. Calls `apply` with key and value of each that is stored and within its
    /// bounds. It writes nothing.
    ///
    /// # Errors
    /// [`StoreError`]; nothing was applied.
    pub fn load(
        &mut self,
        schema: &Schema,
        apply: &mut dyn FnMut(u16, i32),
    ) -> Result<Report, StoreError> {
        let found = self.copies.find()?;
        let mut report = Report::default();
        let Some(header) = found.header() else {
            return if found.damaged {
                Err(StoreError::Damaged)
            } else {
                Ok(report)
            };
        };
        if header.schema == BLANK {
            return Ok(report);
        }
        let mut image = Image::default();
        self.copies.read(&found, &mut image)?;
        report.stored = Some(header.schema);
        report.migrated = header.schema != schema.version;
        report.repaired = found.damaged;
        migrate(&mut image, header.schema, schema)?;
        for row in schema.rows() {
            let Some(got) = image.get(row.key) else {
                continue;
            };
            let (minimum, maximum) = (row.minimum, row.maximum);
            if (minimum..=maximum).contains(&got) {
                apply(row.key, got);
            } else {
                report.refuse(Refused {
                    key: row.key,
                    got,
                    minimum,
                    maximum,
                });
            }
        }
        Ok(report)
    }

    /// Saves all settings if the value of one, returned by `value` for each key, differs from that
    /// in flash. A setting that is not in flash counts as its default.
    ///
    /// A value in flash that is out of bounds stays if the setting has its default, because another
    /// program may accept it. If `is_set` returns true for the key, the default replaces it.
    ///
    /// # Errors
    /// [`StoreError`]; all settings have their old values or all have their new ones.
    pub fn save(
        &mut self,
        schema: &Schema,
        value: &dyn Fn(u16) -> i32,
        is_set: &dyn Fn(u16) -> bool,
    ) -> Result<Saved, StoreError> {
        let found = self.copies.find()?;
        let mut image = Image::default();
        self.copies.read(&found, &mut image)?;
        let mut changed = 0;
        for row in schema.rows() {
            let value = value(row.key);
            let stored = image.get(row.key);
            let refused = stored.is_some_and(|stored| stored < row.minimum || stored > row.maximum);
            let stays = refused && value == row.default && !is_set(row.key);
            if stored.unwrap_or(row.default) != value && !stays {
                image.set(row.key, value)?;
                changed += 1;
            }
        }
        // Earlier programs read these.
        for step in schema.moves {
            let value = (step.down)(current(schema, step.new, value));
            if image.get(step.old) != Some(value) {
                image.set(step.old, value)?;
                changed += 1;
            }
        }
        let complete = found.header().map(|header| header.schema) == Some(schema.version);
        if changed > 0 || !complete || found.damaged {
            self.copies.write(&found, schema.version, &image)?;
        }
        Ok(Saved { changed })
    }

    /// Makes the node blank: from now on, no value in flash counts.
    ///
    /// # Errors
    /// [`StoreError`]; the settings are the old ones or none.
    pub fn clear(&mut self) -> Result<(), StoreError> {
        let found: Found = self.copies.find()?;
        self.copies.write(&found, BLANK, &Image::default())
    }
}

/// Computes the settings that the program has under new keys.
fn migrate(image: &mut Image, stored: u16, schema: &Schema) -> Result<(), StoreError> {
    for step in schema.moves {
        if step.since > stored
            && let Some(value) = image.get(step.old)
        {
            image.set(step.new, (step.up)(value))?;
        }
    }
    Ok(())
}

/// Value of a key, which a later move may have replaced again.
fn current(schema: &Schema, key: u16, value: &dyn Fn(u16) -> i32) -> i32 {
    let mut moves = schema.moves.iter();
    match moves.find(|step| step.old == key) {
        Some(step) => (step.down)(current(schema, step.new, value)),
        None => value(key),
    }
}
