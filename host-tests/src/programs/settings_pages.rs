//! The settings pages of the boards' flash memory, as their programs write them.

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use std::convert::Infallible;
use std::ops::Range;
use tautrack::motor::board_limits::{self, Limit};
use tautrack::settings::{Setting, Settings};
use tautrack::store::{SCHEMA, Schema, Store};

// What the program of the motor board knows.
#[allow(dead_code)] // the program of the board uses the rest
#[path = "../../../firmware/src/boards/esc1/analogue.rs"]
mod analogue;
/// Bounds and defaults of the motor board's settings.
#[path = "../../../firmware/src/boards/esc1/limits.rs"]
pub mod motor_board;

/// Address of the motor board's first page.
pub const ADDRESS: u32 = 0x0801_e000;
/// Address of the first page of the guard's board.
pub const GUARD_ADDRESS: u32 = 0x0807_e000;
/// Bytes of all pages.
pub const LENGTH: usize = 8 * 1024;
/// Bytes of one page.
pub const PAGE: usize = 2 * 1024;

/// Pages in memory.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Pages(pub Vec<u8>);

impl Pages {
    /// Erased pages.
    pub fn erased() -> Self {
        Self(vec![0xff; LENGTH])
    }

    /// Pages with these settings alone. All others have their defaults.
    ///
    /// # Errors
    /// Those of [`Self::save`].
    pub fn of(values: &[(Setting, i32)]) -> Result<Self, String> {
        let mut pages = Self::erased();
        pages.save(values)?;
        Ok(pages)
    }

    /// Saves these settings of a motor board. All others get their defaults.
    ///
    /// # Errors
    /// A text that names the value that is out of its bounds, or the failure of the store.
    pub fn save(&mut self, values: &[(Setting, i32)]) -> Result<(), String> {
        self.save_on(&motor_board::LIMITS, values)
    }

    /// The same for a board with these bounds and defaults.
    ///
    /// # Errors
    /// The same.
    pub fn save_on(&mut self, limits: &[Limit], values: &[(Setting, i32)]) -> Result<(), String> {
        let mut settings = Settings::default();
        board_limits::set_defaults(limits, &mut settings);
        for (setting, value) in values {
            settings
                .set(setting.bounds().key, *value)
                .map_err(|error| error.to_string())?;
        }
        Store::open(self)
            .and_then(|mut store| {
                let value = |key| settings.of_key(key).unwrap_or_default();
                let schema = Schema {
                    row: &|index| board_limits::row(limits, index),
                    ..SCHEMA
                };
                store.save(&schema, &value, &|_| true)
            })
            .map_err(|error| error.to_string())?;
        Ok(())
    }

    fn part(&mut self, bytes: Range<u32>) -> &mut [u8] {
        &mut self.0[bytes.start as usize..bytes.end as usize]
    }
}

impl ErrorType for Pages {
    type Error = Infallible;
}

impl ReadNorFlash for Pages {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        bytes.copy_from_slice(self.part(offset..offset + bytes.len() as u32));
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl NorFlash for Pages {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        self.part(from..to).fill(0xff);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        let length = bytes.len() as u32;
        self.part(offset..offset + length).copy_from_slice(bytes);
        Ok(())
    }
}
