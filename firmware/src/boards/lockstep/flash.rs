//! Simulated flash with pages and words like those of an STM32G4. Its contents are in memory, and
//! also in a file if the simulator names one, or if nodes take turns in the memory.

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
    /// An empty path stands for a file of the node that ends with the program.
    pub unnamed: bool,
}

type Bytes = [u8; PAGES * PAGE];

struct State {
    file: Option<(String<MAX_PATH>, Files)>,
    /// The contents are in [`BYTES`]. Otherwise they are in the file; without a file, they are
    /// blank.
    held: bool,
    /// The file has been read or written. From then on it must exist.
    exists: bool,
    /// Whether the file is older than the bytes, because it could not be written.
    outdated: bool,
}

impl State {
    fn read(&mut self, bytes: &mut Bytes) -> Result<(), NorFlashErrorKind> {
        let found = match &self.file {
            Some((path, files)) => (files.read)(path, bytes),
            None => None,
        };
        match found {
            Some(true) => self.exists = true,
            None if !self.exists => bytes.fill(0xff),
            Some(false) | None => return Err(NorFlashErrorKind::Other),
        }
        self.held = true;
        Ok(())
    }

    fn write_back(&mut self, bytes: &Bytes) -> Result<(), NorFlashErrorKind> {
        self.outdated = match &self.file {
            Some((path, files)) => !(files.write)(path, bytes),
            None => false,
        };
        if self.outdated {
            return Err(NorFlashErrorKind::Other);
        }
        self.exists = self.file.is_some();
        Ok(())
    }
}

static STATE: Mutex<RefCell<State>> = Mutex::new(RefCell::new(State {
    file: None,
    held: false,
    exists: false,
    outdated: false,
}));

#[cfg_attr(target_os = "none", unsafe(link_section = ".seldom.flash"))]
static BYTES: Mutex<RefCell<Bytes>> = Mutex::new(RefCell::new([0; PAGES * PAGE]));

/// Calls `use_it` with the state and the contents.
fn with<R>(
    use_it: impl FnOnce(&mut State, &mut Bytes) -> Result<R, NorFlashErrorKind>,
) -> Result<R, NorFlashErrorKind> {
    critical_section::with(|cs| {
        let mut state = STATE.borrow(cs).borrow_mut();
        let mut bytes = BYTES.borrow(cs).borrow_mut();
        if !state.held {
            state.read(&mut bytes)?;
        }
        use_it(&mut state, &mut bytes)
    })
}

/// Reads the flash from the file `path`; an empty path, and a file that does not exist, leave it
/// blank. A board without `files` has its flash in memory.
///
/// # Errors
/// The file is no flash of this board. It is left as it is.
pub(super) fn insert(path: &String<MAX_PATH>, files: Option<Files>) -> Result<(), ()> {
    let Some(files) = files.filter(|files| files.unnamed || !path.is_empty()) else {
        return Ok(());
    };
    critical_section::with(|cs| STATE.borrow(cs).borrow_mut().file = Some((path.clone(), files)));
    with(|_, _| Ok(())).map_err(|_| ())
}

/// Leaves the contents to the file, if the file has them all. Returns whether [`BYTES`] are still
/// needed.
#[cfg(target_os = "none")]
pub(super) fn release() -> bool {
    critical_section::with(|cs| {
        let mut state = STATE.borrow(cs).borrow_mut();
        state.held &= state.outdated || state.file.is_none();
        state.held
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
        with(|state, contents| {
            // What a reader finds must be in the file.
            if state.outdated {
                state.write_back(contents)?;
            }
            let from = contents.iter().skip(offset as usize);
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
        with(|state, contents| {
            if let Some(bytes) = contents.get_mut(from as usize..to as usize) {
                bytes.fill(0xff);
            }
            state.write_back(contents)
        })
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        with(|state, contents| {
            let to = contents.iter_mut().skip(offset as usize);
            // A written bit cannot be set again.
            to.zip(bytes).for_each(|(to, from)| *to &= *from);
            state.write_back(contents)
        })
    }
}
