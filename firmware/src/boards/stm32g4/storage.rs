//! The settings pages of the flash memory.
//!
//! All interrupts wait while it erases (22 ms a page) or writes. A chip with one bank cannot
//! execute meanwhile. So nothing moves meanwhile: the board is made safe before.

use super::reset;
use crate::boards::Selected;
use core::cell::RefCell;
use core::sync::atomic::{AtomicBool, Ordering};
use critical_section::Mutex;
use embassy_stm32::Peri;
use embassy_stm32::flash::{Blocking, Error, FLASH_BASE, Flash};
use embassy_stm32::pac::FLASH as REGISTERS;
use embassy_stm32::peripherals::FLASH;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

unsafe extern "C" {
    /// Start and end of the settings pages, from the link script.
    static _settings_start: u8;
    static _settings_end: u8;
}

/// Bytes of a page.
const PAGE: usize = 2_048;
/// Bytes that are written at once.
const WORD: usize = 8;

static MEMORY: Mutex<RefCell<Option<Flash<'static, Blocking>>>> = Mutex::new(RefCell::new(None));

/// Prepares the access to the pages.
pub fn start(memory: Peri<'static, FLASH>) {
    critical_section::with(|cs| MEMORY.borrow(cs).replace(Some(Flash::new_blocking(memory))));
}

/// The settings pages are being read.
static READING: AtomicBool = AtomicBool::new(false);

/// Whether the error correction of a word has failed.
pub(super) fn has_error() -> bool {
    REGISTERS.eccr().read().eccd()
}

/// Ends the interrupt of such a word: it would come back for ever. Returns whether the word belongs
/// to the settings: a power cut can leave such a word, and the store finds it by its own checksum.
pub(super) fn clear_error() -> bool {
    REGISTERS.eccr().modify(|errors| errors.set_eccd(true));
    let harmless = READING.load(Ordering::Relaxed);
    if harmless {
        Selected::forget_event();
    }
    harmless
}

/// The settings pages.
pub struct Storage;

impl Storage {
    fn access<R>(
        offset: u32,
        body: impl FnOnce(&mut Flash<'static, Blocking>, u32) -> Result<R, Error>,
    ) -> Result<R, NorFlashErrorKind> {
        let start = &raw const _settings_start as usize - FLASH_BASE;
        reset::feed_watchdog();
        let done = critical_section::with(|cs| {
            let mut memory = MEMORY.borrow(cs).borrow_mut();
            let memory = memory.as_mut().ok_or(NorFlashErrorKind::Other)?;
            body(memory, start as u32 + offset).map_err(|_| NorFlashErrorKind::Other)
        });
        reset::feed_watchdog();
        done
    }
}

/// Makes the board safe before the memory changes. The current loop may have a period to go before
/// it follows a drive that has just been disabled.
fn change<R>(
    offset: u32,
    body: impl FnOnce(&mut Flash<'static, Blocking>, u32) -> Result<R, Error>,
) -> Result<R, NorFlashErrorKind> {
    Storage::access(offset, |memory, place| {
        Selected::make_safe();
        body(memory, place)
    })
}

impl ErrorType for Storage {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Storage {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        check_read(self, offset, bytes.len())?;
        Self::access(offset, |memory, place| {
            READING.store(true, Ordering::SeqCst);
            let done = memory.blocking_read(place, bytes);
            cortex_m::asm::dsb();
            // The interrupt may come later. Then it finds no error.
            if has_error() {
                clear_error();
            }
            READING.store(false, Ordering::SeqCst);
            done
        })
    }

    fn capacity(&self) -> usize {
        &raw const _settings_end as usize - &raw const _settings_start as usize
    }
}

impl NorFlash for Storage {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        check_erase(self, from, to)?;
        for page in (from..to).step_by(PAGE) {
            change(page, |memory, place| {
                memory.blocking_erase(place, place + PAGE as u32)
            })?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        check_write(self, offset, bytes.len())?;
        change(offset, |memory, place| memory.blocking_write(place, bytes))
    }
}
