//! Header of an application image, by which the loader knows that the image is complete.
//!
//! It has four words, little-endian: [`MAGIC`], the length of the image in bytes, the CRC-32 of the
//! image without the header, and 0. The linker places the header; `cargo flash-node` writes length
//! and checksum.

use tautrack::math::Crc32;

/// First word of a header: "TTIM".
pub const MAGIC: u32 = u32::from_le_bytes(*b"TTIM");
/// Offset of the header in the image; memory.x has the same.
const OFFSET: usize = 0x1e0;
/// Bytes of a header.
const LENGTH: usize = 16;

/// Whether `memory` begins with a complete image.
#[allow(dead_code)] // only the loader calls it
pub fn is_valid(memory: &[u8]) -> bool {
    let word = |index: usize| {
        let bytes = memory.get(OFFSET + 4 * index..)?.first_chunk()?;
        Some(u32::from_le_bytes(*bytes))
    };
    let (Some(magic), Some(length), Some(crc)) = (word(0), word(1), word(2)) else {
        return false;
    };
    let (Some(table), Some(code)) = (
        memory.get(..OFFSET),
        memory.get(OFFSET + LENGTH..length as usize),
    ) else {
        return false;
    };
    magic == MAGIC && crc == Crc32::of(table).with(code).value()
}
