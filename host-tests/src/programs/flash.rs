//! Flash images of the motor board: their segments, and the header that the loader checks.
//! [`settings_pages`](super::settings_pages) makes the other part of the flash memory.

use object::read::elf::{ElfFile32, FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSection};
use std::fmt;

/// Bytes of the header that are checked: magic, length, checksum, 0.
const HEADER_LENGTH: usize = 16;

/// Reason why a program is no flash image.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum ImageError {
    /// The file is no ELF file for the chip.
    NoElf(String),
    /// The program has no header, so the loader would not start it.
    NoHeader,
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::NoElf(error) => write!(f, "no ELF file: {error}"),
            Self::NoHeader => write!(f, "the program has no section .image_header"),
        }
    }
}

impl std::error::Error for ImageError {}

/// Bytes at an address of the flash memory.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Segment {
    /// Address of the first byte.
    pub address: u32,
    /// Place of the first byte in the ELF file.
    offset: usize,
    /// The bytes.
    pub bytes: Vec<u8>,
}

/// Returns what a debug probe writes to the flash memory for the program `elf`, in order.
///
/// # Errors
/// [`ImageError::NoElf`].
pub fn segments(elf: &[u8]) -> Result<Vec<Segment>, ImageError> {
    let no_elf = |error: object::Error| ImageError::NoElf(error.to_string());
    let file = ElfFile32::<Endianness>::parse(elf).map_err(no_elf)?;
    let endian = file.endian();
    let headers = file
        .elf_header()
        .program_headers(endian, elf)
        .map_err(no_elf)?;
    let mut segments: Vec<Segment> = headers
        .iter()
        .filter(|header| header.p_type(endian) == object::elf::PT_LOAD)
        .filter(|header| header.p_filesz(endian) > 0)
        .filter_map(|header| {
            let offset = header.p_offset(endian) as usize;
            let end = offset.checked_add(header.p_filesz(endian) as usize)?;
            Some(Segment {
                address: header.p_paddr(endian),
                offset,
                bytes: elf.get(offset..end)?.to_vec(),
            })
        })
        .collect();
    segments.sort_by_key(|segment| segment.address);
    Ok(segments)
}

/// Returns the application `elf` with length and checksum in its header.
///
/// # Errors
/// [`ImageError`].
pub fn sealed(mut elf: Vec<u8>) -> Result<Vec<u8>, ImageError> {
    let segments = segments(&elf)?;
    let (header, place) = {
        let file = ElfFile32::<Endianness>::parse(&*elf)
            .map_err(|error| ImageError::NoElf(error.to_string()))?;
        let section = file
            .section_by_name(".image_header")
            .ok_or(ImageError::NoHeader)?;
        let (place, _) = section.file_range().ok_or(ImageError::NoHeader)?;
        (section.address() as u32, place as usize)
    };
    let first = segments.first().ok_or(ImageError::NoHeader)?.address;
    // Flash memory that nothing is written to reads as ones.
    let mut image = Vec::new();
    for segment in &segments {
        image.resize((segment.address - first) as usize, 0xff);
        image.extend_from_slice(&segment.bytes);
    }
    let at = (header - first) as usize;
    let checksum = crc32(image[..at].iter().chain(&image[at + HEADER_LENGTH..]));
    for (index, word) in [image.len() as u32, checksum].into_iter().enumerate() {
        let place = place + 4 * (1 + index);
        elf[place..place + 4].copy_from_slice(&word.to_le_bytes());
    }
    Ok(elf)
}

/// Computes the CRC-32 of Ethernet and ZIP, bit by bit.
pub fn crc32<'a>(bytes: impl IntoIterator<Item = &'a u8>) -> u32 {
    !bytes.into_iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg())
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_zip() {
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    }
}
