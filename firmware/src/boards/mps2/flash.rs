//! The simulated flash of the settings.

use super::semihosting::Stream;
use crate::boards::lockstep::{self, Files};
use core::cell::RefCell;
use critical_section::Mutex;
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use heapless::String;
use tautrack::link::MAX_PATH;

static FLASH: Mutex<RefCell<lockstep::Flash>> = Mutex::new(RefCell::new(lockstep::Flash::blank()));

const FILES: Files = Files {
    read: |path, bytes| {
        Stream::read_file(path).map(|file| {
            let whole = file.read_exact(bytes) && !file.read_exact(&mut [0]);
            file.close();
            whole
        })
    },
    write: |path, bytes| {
        Stream::write_file(path).is_some_and(|file| {
            let whole = file.write_all(bytes);
            file.close();
            whole
        })
    },
};

fn with<R>(use_it: impl FnOnce(&mut lockstep::Flash) -> R) -> R {
    critical_section::with(|cs| use_it(&mut FLASH.borrow(cs).borrow_mut()))
}

/// Reads the contents from the file `path` ([`lockstep::Flash::insert`]).
pub(super) fn insert(path: &String<MAX_PATH>) -> Result<(), ()> {
    with(|flash| flash.insert(path, FILES))
}

/// Access to the flash.
pub struct Flash;

impl ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = lockstep::Flash::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        with(|flash| flash.read(offset, bytes))
    }

    fn capacity(&self) -> usize {
        with(|flash| flash.capacity())
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = lockstep::Flash::WRITE_SIZE;
    const ERASE_SIZE: usize = lockstep::Flash::ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        with(|flash| flash.erase(from, to))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        with(|flash| flash.write(offset, bytes))
    }
}
