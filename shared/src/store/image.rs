//! The items of the flash, in memory.

use super::StoreError;
use heapless::Vec;

/// Maximum number of keys in flash, unknown ones included.
const MAX_KEYS: usize = 320;
/// Maximum number of records in flash, unknown ones included.
const MAX_RECORDS: usize = 16;

/// Values by key. It takes 2 KiB, so there is only one at a time.
#[derive(Default)]
pub(super) struct Image {
    /// The bytes of a value, unlike the value, need no padding after the key.
    items: Vec<(u16, [u8; 4]), MAX_KEYS>,
    records: Vec<u16, MAX_RECORDS>,
}

impl Image {
    /// Value of `key`, if it is stored.
    pub fn get(&self, key: u16) -> Option<i32> {
        let mut items = self.items.iter();
        let found = items.find(|item| item.0 == key);
        found.map(|item| i32::from_le_bytes(item.1))
    }

    /// Sets the value of `key`.
    ///
    /// # Errors
    /// [`StoreError::TooManyKeys`].
    pub fn set(&mut self, key: u16, value: i32) -> Result<(), StoreError> {
        let value = value.to_le_bytes();
        match self.items.iter_mut().find(|item| item.0 == key) {
            Some(item) => item.1 = value,
            None => self
                .items
                .push((key, value))
                .map_err(|_| StoreError::TooManyKeys { maximum: MAX_KEYS })?,
        }
        Ok(())
    }

    /// Notes that flash has the record `key`.
    ///
    /// # Errors
    /// [`StoreError::TooManyKeys`].
    pub fn note_record(&mut self, key: u16) -> Result<(), StoreError> {
        if self.records.contains(&key) {
            return Ok(());
        }
        let maximum = MAX_RECORDS;
        self.records
            .push(key)
            .map_err(|_| StoreError::TooManyKeys { maximum })
    }

    /// Keys of the records in flash.
    pub fn records(&self) -> &[u16] {
        &self.records
    }

    /// Removes all values and the keys of the records.
    pub fn clear(&mut self) {
        self.items.clear();
        self.records.clear();
    }

    /// Whether nothing is stored.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }
}
