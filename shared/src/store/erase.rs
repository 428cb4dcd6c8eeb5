//! Flash that completes an interrupted erase.
//!
//! A power cut during an erase leaves undefined contents in the page. The crate that keeps the
//! items cannot tell such a page from an intact one. So this layer takes two marks of each page for
//! itself. Before it erases a page, it writes "begun" into the page before it, and after the erase
//! "done". If "done" is missing at start, it erases the page again. The crate erases a page only
//! after it has copied everything needed into the page before.
//!
//! "Begun" is the number of the erase and its complement, so that no torn mark is valid. An
//! interrupted erase may leave an old "begun" in the page and take its "done" away. So the highest
//! number counts.
//!
//! The marks of a page are written once between two erases of this page. A further erase of the
//! same neighbour is not recorded. The crate makes one only to discard copies, whose originals it
//! still has.

use embedded_storage::nor_flash::{self as blocking, NorFlashError};
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};

/// Largest word of a flash, bytes.
pub(super) const MAX_WORD: usize = 32;

/// Flash with pages that are two marks shorter than those of `F`.
pub(super) struct SafeErase<F> {
    flash: F,
}

impl<F: blocking::NorFlash> SafeErase<F> {
    /// Length of a mark, bytes: whole words for two numbers of 32 bits.
    const MARK: usize = if F::WRITE_SIZE > 8 { F::WRITE_SIZE } else { 8 };

    /// Completes an interrupted erase. Returns the flash, and whether there was one to complete.
    ///
    /// # Errors
    /// The kind of the flash's error.
    pub fn new(flash: F) -> Result<(Self, bool), NorFlashErrorKind> {
        let mut flash = Self { flash };
        let mut interrupted = None;
        for page in 0..flash.pages() {
            if let Some(number) = flash.begun(page)?
                && !flash.done(page)?
                && interrupted.is_none_or(|(_, highest)| number > highest)
            {
                interrupted = Some((page, number));
            }
        }
        if let Some((page, _)) = interrupted {
            flash.erase_page(flash.after(page))?;
            flash.write_mark(page, Mark::Done, [0; MAX_WORD])?;
        }
        Ok((flash, interrupted.is_some()))
    }

    /// Size of all pages as the crate sees them, bytes.
    pub fn size(&self) -> u32 {
        self.pages() * Self::ERASE_SIZE as u32
    }

    /// Gives the flash back.
    pub fn into_inner(self) -> F {
        self.flash
    }

    fn pages(&self) -> u32 {
        (self.flash.capacity() / F::ERASE_SIZE) as u32
    }

    fn after(&self, page: u32) -> u32 {
        if page + 1 == self.pages() {
            0
        } else {
            page + 1
        }
    }

    fn before(&self, page: u32) -> u32 {
        page.checked_sub(1).unwrap_or(self.pages() - 1)
    }

    fn mark_address(page: u32, mark: Mark) -> u32 {
        (page + 1) * F::ERASE_SIZE as u32 - (2 - mark as u32) * Self::MARK as u32
    }

    /// Number of the erase that was begun after this page.
    fn begun(&mut self, page: u32) -> Result<Option<u32>, NorFlashErrorKind> {
        let [a, b, c, d, complement @ ..] = self.mark::<8>(page, Mark::Begun)?;
        let number = u32::from_le_bytes([a, b, c, d]);
        Ok((u32::from_le_bytes(complement) == !number).then_some(number))
    }

    /// Whether "done" is written. A torn one does not count: the erased page is not in use then.
    fn done(&mut self, page: u32) -> Result<bool, NorFlashErrorKind> {
        Ok(self.mark(page, Mark::Done)? == [0; 8])
    }

    fn is_blank(&mut self, page: u32, mark: Mark) -> Result<bool, NorFlashErrorKind> {
        Ok(self.mark(page, mark)? == [0xff; 8])
    }

    fn mark<const N: usize>(
        &mut self,
        page: u32,
        mark: Mark,
    ) -> Result<[u8; N], NorFlashErrorKind> {
        let mut bytes = [0xff; N];
        self.flash
            .read(Self::mark_address(page, mark), &mut bytes)
            .map_err(|error| error.kind())?;
        Ok(bytes)
    }

    fn write_mark(
        &mut self,
        page: u32,
        mark: Mark,
        bytes: [u8; MAX_WORD],
    ) -> Result<(), NorFlashErrorKind> {
        self.flash
            .write(Self::mark_address(page, mark), &bytes[..Self::MARK])
            .map_err(|error| error.kind())
    }

    /// Writes "begun" into `page`, unless a mark is there already. Returns whether it was written.
    fn begin(&mut self, page: u32) -> Result<bool, NorFlashErrorKind> {
        if !self.is_blank(page, Mark::Begun)? || !self.is_blank(page, Mark::Done)? {
            return Ok(false);
        }
        let mut number = 0;
        for other in 0..self.pages() {
            if let Some(earlier) = self.begun(other)? {
                number = number.max(earlier.wrapping_add(1));
            }
        }
        let mut bytes = [0; MAX_WORD];
        bytes[..4].copy_from_slice(&number.to_le_bytes());
        bytes[4..8].copy_from_slice(&(!number).to_le_bytes());
        self.write_mark(page, Mark::Begun, bytes)?;
        Ok(true)
    }

    fn erase_page(&mut self, page: u32) -> Result<(), NorFlashErrorKind> {
        let size = F::ERASE_SIZE as u32;
        self.flash
            .erase(page * size, (page + 1) * size)
            .map_err(|error| error.kind())
    }

    /// Address in the flash of an address that the crate uses.
    fn address(offset: u32) -> u32 {
        let size = Self::ERASE_SIZE as u32;
        offset / size * F::ERASE_SIZE as u32 + offset % size
    }
}

/// The two marks at the end of a page. "Done" is zeros, because flash with error correction allows
/// zeros over a torn word.
#[derive(Clone, Copy)]
enum Mark {
    Begun,
    Done,
}

impl<F> ErrorType for SafeErase<F> {
    type Error = NorFlashErrorKind;
}

impl<F: blocking::NorFlash> ReadNorFlash for SafeErase<F> {
    const READ_SIZE: usize = F::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        self.flash
            .read(Self::address(offset), bytes)
            .map_err(|error| error.kind())
    }

    fn capacity(&self) -> usize {
        self.size() as usize
    }
}

impl<F: blocking::NorFlash> NorFlash for SafeErase<F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = F::ERASE_SIZE - 2 * Self::MARK;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        let size = Self::ERASE_SIZE as u32;
        for page in from / size..to / size {
            let before = self.before(page);
            let recorded = self.begin(before)?;
            self.erase_page(page)?;
            if recorded {
                self.write_mark(before, Mark::Done, [0; MAX_WORD])?;
            }
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        self.flash
            .write(Self::address(offset), bytes)
            .map_err(|error| error.kind())
    }
}
