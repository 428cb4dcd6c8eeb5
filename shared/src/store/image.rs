//! The items of the flash, in memory.

use super::StoreError;
use heapless::Vec;

/// Maximum number of keys in flash, unknown ones included.
const MAX_KEYS: usize = 320;

/// Values by key. It takes 2 KiB, so there is only one at a time.
#[derive(Default)]
pub(super) struct Image {
    /// The bytes of a value, unlike the value, need no padding after the key.
    items: Vec<(u16, [u8; 4]), MAX_KEYS>,
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

    /// All keys with their values, little-endian.
    pub fn items(&self) -> &[(u16, [u8; 4])] {
        &self.items
    }
}
