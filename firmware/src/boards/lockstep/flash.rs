//! Simulated flash with pages and words like those of an STM32G4. Its contents are in memory and,
//! if the simulator names one, in a file.

use core::cell::RefCell;
use critical_section::Mutex;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use heapless::String;
use tautrack::link::MAX_PATH;

/// Bytes of a page.
const PAGE: usize = 2_048;
/// Pages for the settings.
const PAGES: usize = 4;
/// Bytes of a word.
const WORD: usize = 8;

/// Access of a board to the host's files.
#[derive(Clone, Copy)]
pub struct Files {
    /// Reads the file with this path into the buffer. Returns whether the file has the length of
    /// the buffer; `None` if there is no file.
    pub read: fn(&str, &mut [u8]) -> Option<bool>,
    /// Writes the file with this path, without making it shorter meanwhile. Returns whether it
    /// succeeded.
    pub write: fn(&str, &[u8]) -> bool,
}

struct Contents {
    bytes: [u8; PAGES * PAGE],
    file: Option<(String<MAX_PATH>, Files)>,
    /// Whether the file is older than the bytes, because it could not be written.
    outdated: bool,
}

impl Contents {
    fn write_back(&mut self) -> Result<(), NorFlashErrorKind> {
        self.outdated = match &self.file {
            Some((path, files)) => !(files.write)(path, &self.bytes),
            None => false,
        };
        if self.outdated {
            return Err(NorFlashErrorKind::Other);
        }
        Ok(())
    }
}

static CONTENTS: Mutex<RefCell<Contents>> = Mutex::new(RefCell::new(Contents {
    bytes: [0xff; PAGES * PAGE],
    file: None,
    outdated: false,
}));

/// Reads the flash from the file `path`; an empty path leaves it blank. A board without `files` has
/// its flash in memory.
///
/// # Errors
/// The file is no flash of this board. It is left as it is.
pub(super) fn insert(path: &String<MAX_PATH>, files: Option<Files>) -> Result<(), ()> {
    let Some(files) = files.filter(|_| !path.is_empty()) else {
        return Ok(());
    };
    critical_section::with(|cs| {
        let mut contents = CONTENTS.borrow(cs).borrow_mut();
        match (files.read)(path, &mut contents.bytes) {
            Some(true) => {}
            Some(false) => return Err(()),
            None => contents.bytes.fill(0xff),
        }
        contents.file = Some((path.clone(), files));
        Ok(())
    })
}

/// Flash of a lockstep board.
pub struct Flash;

impl ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, bytes.len())?;
        critical_section::with(|cs| {
            let mut contents = CONTENTS.borrow(cs).borrow_mut();
            // What a reader finds must be in the file.
            if contents.outdated {
                contents.write_back()?;
            }
            let from = contents.bytes.iter().skip(offset as usize);
            bytes
                .iter_mut()
                .zip(from)
                .for_each(|(to, from)| *to = *from);
            Ok(())
        })
    }

    fn capacity(&self) -> usize {
        PAGES * PAGE
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check_erase(self, from, to)?;
        critical_section::with(|cs| {
            let mut contents = CONTENTS.borrow(cs).borrow_mut();
            if let Some(bytes) = contents.bytes.get_mut(from as usize..to as usize) {
                bytes.fill(0xff);
            }
            contents.write_back()
        })
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        critical_section::with(|cs| {
            let mut contents = CONTENTS.borrow(cs).borrow_mut();
            let to = contents.bytes.iter_mut().skip(offset as usize);
            // A written bit cannot be set again.
            to.zip(bytes).for_each(|(to, from)| *to &= *from);
            contents.write_back()
        })
    }
}
