//! The items of the flash, in memory.

use super::StoreError;
use heapless::Vec;

/// Maximum number of keys in flash, unknown ones included.
const MAX_KEYS: usize = 320;

/// Values by key. It takes 2.5 KiB, so there is only one at a time.
#[derive(Default)]
pub(super) struct Image {
    items: Vec<(u16, i32), MAX_KEYS>,
}

impl Image {
    /// Value of `key`, if it is stored.
    pub fn get(&self, key: u16) -> Option<i32> {
        let mut items = self.items.iter();
        items.find(|item| item.0 == key).map(|item| item.1)
    }

    /// Sets the value of `key`.
    ///
    /// # Errors
    /// [`StoreError::TooManyKeys`].
    pub fn set(&mut self, key: u16, value: i32) -> Result<(), StoreError> {
        match self.items.iter_mut().find(|item| item.0 == key) {
            Some(item) => item.1 = value,
            None => self
                .items
                .push((key, value))
                .map_err(|_| StoreError::TooManyKeys { maximum: MAX_KEYS })?,
        }
        Ok(())
    }

    /// Removes all values.
    pub fn clear(&mut self) {
        self.items.clear();
    }

    /// Whether nothing is stored.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }
}
