//! Two copies of the settings in flash, of which the newer counts.
//!
//! Each copy has one half of the pages. A save erases the half that does not count, writes the
//! items and then the header, whose checksum is over the whole copy. So a power cut at any time
//! leaves the earlier copy or all of the new one. Numbers are little-endian:
//!
//! ```text
//! block 0    sequence u32, schema u16, blocks of items u16, CRC-32 u32, 20 bytes ff
//! block 1..  four items: key u16, value i32, 2 bytes ff; an unused item is ff
//! ```

use super::StoreError;
use super::image::Image;
use crate::math::Crc32;
use embedded_storage::nor_flash::NorFlash;

/// Bytes that are read and written at once. Suitable flash has words of at most so many.
pub(super) const BLOCK: usize = 32;
const ITEM: usize = 8;
/// Number of an item that is not used, and byte of erased flash.
const UNUSED: u16 = u16::MAX;
const ERASED: u8 = u8::MAX;

/// Header of a copy.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Header {
    /// Number of the save; the copy with the higher one counts.
    sequence: u32,
    /// Version of the schema.
    pub schema: u16,
    /// Blocks of items behind this one.
    blocks: u16,
    /// Checksum of the numbers above and of all items.
    checksum: u32,
}

impl Header {
    /// A header of these numbers, with the checksum of an empty copy.
    fn new(sequence: u32, schema: u16, blocks: u16) -> Self {
        let mut header = Self {
            sequence,
            schema,
            blocks,
            checksum: 0,
        };
        header.checksum = header.numbers().value();
        header
    }

    fn numbers(&self) -> Crc32 {
        Crc32::of(&self.block()[..ITEM])
    }

    fn block(&self) -> [u8; BLOCK] {
        let mut block = [ERASED; BLOCK];
        block[..4].copy_from_slice(&self.sequence.to_le_bytes());
        block[4..6].copy_from_slice(&self.schema.to_le_bytes());
        block[6..8].copy_from_slice(&self.blocks.to_le_bytes());
        block[8..12].copy_from_slice(&self.checksum.to_le_bytes());
        block
    }

    fn read(block: &[u8; BLOCK]) -> Self {
        let [a, b, c, d, e, f, g, h, i, j, k, l, ..] = *block;
        Self {
            sequence: u32::from_le_bytes([a, b, c, d]),
            schema: u16::from_le_bytes([e, f]),
            blocks: u16::from_le_bytes([g, h]),
            checksum: u32::from_le_bytes([i, j, k, l]),
        }
    }
}

/// Contents of a half.
enum Half {
    Erased,
    /// Neither erased nor whole.
    Damaged,
    Whole(Header),
}

/// What is in flash.
#[derive(Default)]
pub(super) struct Found {
    /// The copy that counts, with the number of its half.
    newest: Option<(u32, Header)>,
    /// Whether a half is neither erased nor a whole copy.
    pub damaged: bool,
}

impl Found {
    /// Header of the copy that counts.
    pub fn header(&self) -> Option<Header> {
        self.newest.map(|(_, header)| header)
    }
}

/// The flash with the copies.
pub(super) struct Copies<F> {
    pub flash: F,
}

impl<F: NorFlash> Copies<F> {
    /// Bytes of a half.
    fn half(&self) -> u32 {
        (self.flash.capacity() / F::ERASE_SIZE / 2 * F::ERASE_SIZE) as u32
    }

    /// Reads both halves.
    ///
    /// # Errors
    /// [`StoreError::Flash`].
    pub fn find(&mut self) -> Result<Found, StoreError> {
        let mut found = Found::default();
        for half in 0..2 {
            match self.inspect(half)? {
                Half::Erased => {}
                Half::Damaged => found.damaged = true,
                Half::Whole(header) => {
                    if found
                        .header()
                        .is_none_or(|other| header.sequence > other.sequence)
                    {
                        found.newest = Some((half, header));
                    }
                }
            }
        }
        Ok(found)
    }

    fn inspect(&mut self, half: u32) -> Result<Half, StoreError> {
        let header = Header::read(&self.block(half, 0)?);
        let mut checksum = header.numbers();
        let mut erased = true;
        let blocks = self.half() / BLOCK as u32;
        for number in 0..blocks {
            let block = self.block(half, number)?;
            erased &= block == [ERASED; BLOCK];
            if (1..=u32::from(header.blocks)).contains(&number) {
                checksum = checksum.with(&block);
            }
        }
        let whole = u32::from(header.blocks) < blocks && checksum.value() == header.checksum;
        Ok(match (whole, erased) {
            (true, _) => Half::Whole(header),
            (_, true) => Half::Erased,
            _ => Half::Damaged,
        })
    }

    fn block(&mut self, half: u32, number: u32) -> Result<[u8; BLOCK], StoreError> {
        let mut block = [0; BLOCK];
        let place = half * self.half() + number * BLOCK as u32;
        self.flash.read(place, &mut block)?;
        Ok(block)
    }

    /// Reads the items of the copy that counts.
    ///
    /// # Errors
    /// [`StoreError::Flash`] or [`StoreError::TooManyKeys`].
    pub fn read(&mut self, found: &Found, image: &mut Image) -> Result<(), StoreError> {
        let Some((half, header)) = found.newest else {
            return Ok(());
        };
        for number in 1..=u32::from(header.blocks) {
            let block = self.block(half, number)?;
            for [a, b, c, d, e, f, ..] in block.as_chunks::<ITEM>().0 {
                let key = u16::from_le_bytes([*a, *b]);
                if key != UNUSED {
                    image.set(key, i32::from_le_bytes([*c, *d, *e, *f]))?;
                }
            }
        }
        Ok(())
    }

    /// Writes a copy that counts more than what was `found`, and reads it back.
    ///
    /// # Errors
    /// [`StoreError`]; the copy that counted before still counts, or the new one is whole.
    pub fn write(&mut self, found: &Found, schema: u16, image: &Image) -> Result<(), StoreError> {
        let size = self.half();
        let (half, sequence, erased) = match found.newest {
            Some((half, header)) => (1 - half, header.sequence.wrapping_add(1), size),
            // Both halves, because what is in the other one would count as damage.
            None => (0, 0, 2 * size),
        };
        let start = half * size;
        let items = image.items().chunks(BLOCK / ITEM);
        if (items.len() + 1) * BLOCK > size as usize {
            return Err(StoreError::Full);
        }
        self.flash.erase(start, start + erased)?;
        let mut header = Header::new(sequence, schema, items.len() as u16);
        let mut checksum = header.numbers();
        let mut place = start;
        for items in items {
            let mut block = [ERASED; BLOCK];
            for (bytes, (key, value)) in block.chunks_exact_mut(ITEM).zip(items) {
                bytes[..2].copy_from_slice(&key.to_le_bytes());
                bytes[2..6].copy_from_slice(value);
            }
            place += BLOCK as u32;
            self.flash.write(place, &block)?;
            checksum = checksum.with(&block);
        }
        header.checksum = checksum.value();
        self.flash.write(start, &header.block())?;
        match self.inspect(half)? {
            Half::Whole(written) if written == header => Ok(()),
            _ => Err(StoreError::NotVerified),
        }
    }
}
