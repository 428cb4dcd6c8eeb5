//! Simulated flash with pages and words like those of an STM32G4. Its contents are in memory, and
//! also in a file if the simulator names one.

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

/// Flash of a board without hardware.
pub struct Flash {
    bytes: [u8; PAGES * PAGE],
    file: Option<(String<MAX_PATH>, Files)>,
    /// Whether the file is older than the bytes, because it could not be written.
    outdated: bool,
}

impl Flash {
    /// Blank flash without a file.
    pub const fn blank() -> Self {
        Self {
            bytes: [0xff; PAGES * PAGE],
            file: None,
            outdated: false,
        }
    }

    /// Reads the contents from the file `path` of `files`; an empty path, and a file that does not
    /// exist, leave the flash blank.
    ///
    /// # Errors
    /// The file is no flash of this board. It is left as it is.
    pub fn insert(&mut self, path: &String<MAX_PATH>, files: Files) -> Result<(), ()> {
        if path.is_empty() {
            return Ok(());
        }
        self.file = Some((path.clone(), files));
        match (files.read)(path, &mut self.bytes) {
            Some(true) => Ok(()),
            Some(false) => Err(()),
            None => {
                self.bytes.fill(0xff);
                Ok(())
            }
        }
    }

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

impl ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, bytes.len())?;
        // What a reader finds must be in the file.
        if self.outdated {
            self.write_back()?;
        }
        let from = self.bytes.iter().skip(offset as usize);
        bytes
            .iter_mut()
            .zip(from)
            .for_each(|(to, from)| *to = *from);
        Ok(())
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
        if let Some(bytes) = self.bytes.get_mut(from as usize..to as usize) {
            bytes.fill(0xff);
        }
        self.write_back()
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        let to = self.bytes.iter_mut().skip(offset as usize);
        // A written bit cannot be set again.
        to.zip(bytes).for_each(|(to, from)| *to &= *from);
        self.write_back()
    }
}
