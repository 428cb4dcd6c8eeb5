//! Loads settings from flash and saves them.

use super::erase::{MAX_WORD, SafeErase};
use super::image::Image;
use super::{Record, Refused, Report, Schema};
use crate::settings::Bounds;
use core::fmt;
use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use embedded_storage::nor_flash::{NorFlash, NorFlashErrorKind};
use sequential_storage::Error;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};

/// Key of the item that has the schema version, and whether the last save was completed.
const SCHEMA_KEY: u16 = 0;
/// Added to the schema version while a save is under way.
const UNDER_WAY: i32 = 0x1_0000;
/// Schema version of a store that was cleared.
const BLANK: i32 = 0;
/// Bytes of a key and a value in a record.
const PAIR: usize = 6;
/// Bytes of the largest page. A power cut can tear the length of an item so that its checksum is
/// right by chance. Such an item is read with up to all bytes of its page before it is found wrong.
const BUFFER: usize = 2_048;

/// Why the store failed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum StoreError {
    /// The flash has fewer than two pages, pages above 2 KiB, or words above 32 bytes.
    UnsuitableFlash,
    /// The flash refused an access.
    Flash(NorFlashErrorKind),
    /// The flash has no room for a value. Every old value is still there.
    Full,
    /// The pages cannot be read as items.
    Damaged,
    /// The flash does not hold the value that was written.
    NotVerified {
        /// Key of the setting.
        key: u16,
    },
    /// More keys than the program can read.
    TooManyKeys {
        /// The maximum number.
        maximum: usize,
    },
}

impl fmt::Display for StoreError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnsuitableFlash => write!(
                out,
                "the flash has too few pages, or too large pages or words"
            ),
            Self::Flash(kind) => write!(out, "the flash refused an access: {kind:?}"),
            Self::Full => write!(out, "the flash is full"),
            Self::Damaged => write!(out, "the flash holds no settings that can be read"),
            Self::NotVerified { key } => write!(out, "setting {key:#06x} was not written"),
            Self::TooManyKeys { maximum } => write!(out, "more than {maximum} keys in flash"),
        }
    }
}

impl From<Error<NorFlashErrorKind>> for StoreError {
    fn from(error: Error<NorFlashErrorKind>) -> Self {
        match error {
            Error::Storage { value, .. } => Self::Flash(value),
            Error::FullStorage | Error::ItemTooBig => Self::Full,
            _ => Self::Damaged,
        }
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
/// A power cut at any time leaves each setting with its old or its new value, and each [`Record`]
/// with all old or all new ones. Keys that the program does not know stay in flash.
pub struct Store<F: NorFlash> {
    map: MapStorage<u16, SafeErase<F>, Cache<Uncached, Uncached, Uncached, u16>>,
    completed_erase: bool,
}

impl<F: NorFlash> Store<F> {
    /// Opens the store in the whole of `flash`. Completes an erase that a power cut interrupted.
    ///
    /// # Errors
    /// [`StoreError::UnsuitableFlash`] or [`StoreError::Flash`].
    pub fn open(flash: F) -> Result<Self, StoreError> {
        let words_fit = F::WRITE_SIZE <= MAX_WORD && F::ERASE_SIZE > 8 * F::WRITE_SIZE;
        let pages_fit = F::ERASE_SIZE <= BUFFER && flash.capacity() >= 2 * F::ERASE_SIZE;
        if !words_fit || !pages_fit {
            return Err(StoreError::UnsuitableFlash);
        }
        let (flash, completed_erase) = SafeErase::new(flash).map_err(StoreError::Flash)?;
        let config =
            MapConfig::try_new(0..flash.size()).map_err(|_| StoreError::UnsuitableFlash)?;
        Ok(Self {
            map: MapStorage::new(flash, config, Cache::new_uncached()),
            completed_erase,
        })
    }

    /// Gives the flash back.
    pub fn into_inner(self) -> F {
        self.map.destroy().0.into_inner()
    }

    /// Reads all settings. Calls `apply` with key and value of each that is stored and within its
    /// bounds. It writes nothing but repairs.
    ///
    /// # Errors
    /// [`StoreError`]; nothing was applied.
    pub fn load(
        &mut self,
        schema: &Schema,
        apply: &mut dyn FnMut(u16, i32),
    ) -> Result<Report, StoreError> {
        let mut image = Image::default();
        self.read(&mut image)?;
        let mut report = Report {
            repaired: self.completed_erase,
            ..Report::default()
        };
        if image.is_empty() {
            return Ok(report);
        }
        let (stored, under_way) = version(&image);
        if i32::from(stored) == BLANK {
            return Ok(report);
        }
        report.stored = Some(stored);
        report.migrated = stored != schema.version;
        report.repaired |= under_way;
        migrate(&mut image, schema)?;
        for row in schema.rows {
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

    /// Saves the settings whose values, returned by `value` for each key, differ from those in
    /// flash. Reads them back afterwards. A setting that is not in flash counts as its default.
    ///
    /// A value in flash that is out of bounds stays if the setting has its default, because another
    /// program may accept it. If `is_set` returns true for the key, the default replaces it.
    ///
    /// # Errors
    /// [`StoreError`]; each setting has its old or its new value.
    pub fn save(
        &mut self,
        schema: &Schema,
        value: &dyn Fn(u16) -> i32,
        is_set: &dyn Fn(u16) -> bool,
    ) -> Result<Saved, StoreError> {
        let mut stored = Image::default();
        self.read(&mut stored)?;
        let changes = Changes {
            stored: &stored,
            schema,
            value,
            is_set,
        };
        let changed = changes.count();
        let at_rest = i32::from(schema.version);
        let complete = stored.get(SCHEMA_KEY) == Some(at_rest);
        if changed == 0 && complete {
            return Ok(Saved::default());
        }
        // The version in flash stays the old one until all settings are written.
        let before = match stored.get(SCHEMA_KEY) {
            Some(word) => word | UNDER_WAY,
            None => BLANK | UNDER_WAY,
        };
        // A single change is whole or not there, so it needs no mark.
        if (changed > 1 || !complete) && stored.get(SCHEMA_KEY) != Some(before) {
            self.write(SCHEMA_KEY, &before.to_le_bytes())?;
        }
        changes.each(&mut |key, bytes| self.write(key, bytes))?;
        self.update_unknown_records(&changes)?;
        if changed > 1 || !complete {
            self.write(SCHEMA_KEY, &at_rest.to_le_bytes())?;
        }
        self.completed_erase = false;
        self.read(&mut stored)?;
        let check = Changes {
            stored: &stored,
            schema,
            value,
            is_set,
        };
        match check.first() {
            Some(key) => Err(StoreError::NotVerified { key }),
            None if stored.get(SCHEMA_KEY) != Some(at_rest) => {
                Err(StoreError::NotVerified { key: SCHEMA_KEY })
            }
            None => Ok(Saved { changed }),
        }
    }

    /// Makes the node blank: from now on, no value in flash counts. Flash that is full or cannot be
    /// read is erased.
    ///
    /// # Errors
    /// [`StoreError`]; the settings are the old ones or none. If the flash had to be erased, they
    /// may also be a part of the old ones.
    pub fn clear(&mut self) -> Result<(), StoreError> {
        let readable = self.read(&mut Image::default());
        match readable.and_then(|()| self.write(SCHEMA_KEY, &BLANK.to_le_bytes())) {
            Err(StoreError::Damaged | StoreError::Full | StoreError::TooManyKeys { .. }) => {
                Ok(block_on(self.map.erase_all())?)
            }
            written => written,
        }
    }

    /// Writes the changes into the records that only another program knows. They would count more
    /// than the single items.
    #[inline(never)] // its buffer must not lie on the stack while the others do
    fn update_unknown_records(&mut self, changes: &Changes) -> Result<(), StoreError> {
        for key in changes.stored.records() {
            if changes
                .schema
                .records
                .iter()
                .any(|record| record.key == *key)
            {
                continue;
            }
            let mut buffer = [0; BUFFER];
            let mut bytes = [0; PAIR * Record::MAX_SETTINGS];
            let item = block_on(self.map.fetch_item::<&[u8]>(&mut buffer, key))?;
            let Some((item, bytes)) =
                item.and_then(|item| Some((item, bytes.get_mut(..item.len())?)))
            else {
                continue;
            };
            bytes.copy_from_slice(item);
            if changes.apply(bytes) {
                self.write(*key, bytes)?;
            }
        }
        Ok(())
    }

    fn write(&mut self, key: u16, bytes: &[u8]) -> Result<(), StoreError> {
        let mut buffer = [0; BUFFER];
        Ok(block_on(self.map.store_item(&mut buffer, &key, &bytes))?)
    }

    /// Reads all items into `image`. Values in records count more than single ones of the same key.
    fn read(&mut self, image: &mut Image) -> Result<(), StoreError> {
        image.clear();
        for records in [false, true] {
            block_on(self.read_into(image, records))?;
        }
        Ok(())
    }

    async fn read_into(&mut self, image: &mut Image, records: bool) -> Result<(), StoreError> {
        let mut buffer = [0; BUFFER];
        let mut items = self.map.fetch_all_items(&mut buffer).await?;
        // Of several items with one key, the last is the newest.
        while let Some((key, bytes)) = items.next::<&[u8]>(&mut buffer).await? {
            if records != (key >= Record::FIRST_KEY) {
                continue;
            }
            if let Ok(value) = bytes.try_into() {
                image.set(key, i32::from_le_bytes(value))?;
            } else if records {
                image.note_record(key)?;
                for pair in bytes.chunks_exact(PAIR) {
                    let (key, value) = pair.split_at(2);
                    if let (Ok(key), Ok(value)) = (key.try_into(), value.try_into()) {
                        image.set(u16::from_le_bytes(key), i32::from_le_bytes(value))?;
                    }
                }
            }
        }
        Ok(())
    }
}

/// Schema version in flash, and whether a save was under way.
fn version(image: &Image) -> (u16, bool) {
    let word = image.get(SCHEMA_KEY).unwrap_or_default();
    (word as u16, word & UNDER_WAY != 0)
}

/// Computes the settings that the program has under new keys.
fn migrate(image: &mut Image, schema: &Schema) -> Result<(), StoreError> {
    let (stored, _) = version(image);
    for step in schema.moves {
        if step.since > stored
            && let Some(value) = image.get(step.old)
        {
            image.set(step.new, (step.up)(value))?;
        }
    }
    Ok(())
}

/// Writes the bytes of the item with this key.
type Write<'a> = dyn FnMut(u16, &[u8]) -> Result<(), StoreError> + 'a;

/// The settings that differ from those in flash.
struct Changes<'a> {
    stored: &'a Image,
    schema: &'a Schema<'a>,
    value: &'a dyn Fn(u16) -> i32,
    is_set: &'a dyn Fn(u16) -> bool,
}

impl Changes<'_> {
    /// Calls `write` with key and bytes of each item to write.
    fn each(&self, write: &mut Write) -> Result<(), StoreError> {
        let grouped = |key: u16| {
            let mut records = self.schema.records.iter();
            records.any(|record| record.settings.iter().any(|one| one.bounds().key == key))
        };
        for (row, value) in self.rows() {
            if !grouped(row) {
                write(row, &value.to_le_bytes())?;
            }
        }
        for record in self.schema.records {
            let keys = || record.settings.iter().map(|one| one.bounds().key);
            if !self.rows().any(|(row, _)| keys().any(|key| key == row)) {
                continue;
            }
            let mut bytes = heapless::Vec::<u8, { PAIR * Record::MAX_SETTINGS }>::new();
            for key in keys() {
                let value = (self.value)(key);
                // Cannot fail: a record has at most as many settings.
                let _ = bytes.extend_from_slice(&key.to_le_bytes());
                let _ = bytes.extend_from_slice(&value.to_le_bytes());
            }
            write(record.key, &bytes)?;
        }
        // Earlier programs read these.
        for (key, value) in self.old_keys() {
            write(key, &value.to_le_bytes())?;
        }
        Ok(())
    }

    /// Replaces the values in a record by those that differ. Returns whether there are any.
    fn apply(&self, record: &mut [u8]) -> bool {
        let mut replaced = false;
        for pair in record.chunks_exact_mut(PAIR) {
            let (key, bytes) = pair.split_at_mut(2);
            for (row, value) in self.rows() {
                if *key == row.to_le_bytes() {
                    bytes.copy_from_slice(&value.to_le_bytes());
                    replaced = true;
                }
            }
        }
        replaced
    }

    fn count(&self) -> usize {
        self.rows().count() + self.old_keys().count()
    }

    fn first(&self) -> Option<u16> {
        let first = self.rows().next().or_else(|| self.old_keys().next());
        first.map(|one| one.0)
    }

    /// Rows that differ, with their new values. A refused value stays until its setting is set or
    /// the store is cleared.
    fn rows(&self) -> impl Iterator<Item = (u16, i32)> {
        let cleared = i32::from(version(self.stored).0) == BLANK;
        let rows = self.schema.rows.iter();
        rows.filter_map(move |row| self.change(row, cleared))
    }

    /// Returns a row with its new value if it differs.
    #[inline(never)] // one copy for all users of the rows
    fn change(&self, row: &Bounds, cleared: bool) -> Option<(u16, i32)> {
        let value = (self.value)(row.key);
        let stored = self.stored.get(row.key);
        let refused = stored.is_some_and(|stored| stored < row.minimum || stored > row.maximum);
        let stays = refused && value == row.default && !cleared && !(self.is_set)(row.key);
        let differs = stored.unwrap_or(row.default) != value;
        (differs && !stays).then_some((row.key, value))
    }

    /// Value of a key, which a later move may have replaced again.
    fn current(&self, key: u16) -> i32 {
        let mut moves = self.schema.moves.iter();
        match moves.find(|step| step.old == key) {
            Some(step) => (step.down)(self.current(step.new)),
            None => (self.value)(key),
        }
    }

    /// Earlier keys of settings, where flash holds another value.
    fn old_keys(&self) -> impl Iterator<Item = (u16, i32)> {
        self.schema.moves.iter().filter_map(|step| {
            let value = (step.down)(self.current(step.new));
            (self.stored.get(step.old) != Some(value)).then_some((step.old, value))
        })
    }
}

/// Runs a future that never waits: the flash below answers at once.
fn block_on<T>(future: impl Future<Output = T>) -> T {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(output) = future.as_mut().poll(&mut context) {
            return output;
        }
    }
}
