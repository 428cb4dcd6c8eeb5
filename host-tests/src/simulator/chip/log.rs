//! Reads the log that an image writes to a ring buffer in RAM, as a debug probe does (SEGGER RTT).

use super::Chip;

/// First bytes of the control block, once the image has initialised it.
const MAGIC: &[u8; 10] = b"SEGGER RTT";
/// Offsets in the control block of the words that describe the first channel.
const BUFFER: u32 = 28;
const SIZE: u32 = 32;
const WRITTEN: u32 = 36;
const READ: u32 = 40;

/// Removes and returns at most `most` bytes of the log, whose control block is at this address.
pub(super) fn take(chip: &mut Chip, control_block: u32, most: usize) -> Vec<u8> {
    let word = |chip: &Chip, offset: u32| {
        let bytes = chip.memory(control_block + offset, 4);
        bytes.try_into().map_or(0, u32::from_le_bytes)
    };
    if chip.memory(control_block, MAGIC.len()) != MAGIC {
        return Vec::new();
    }
    let (buffer, size) = (word(chip, BUFFER), word(chip, SIZE));
    let (mut read, written) = (word(chip, READ), word(chip, WRITTEN));
    let mut bytes = Vec::new();
    while read != written && read < size && bytes.len() < most {
        bytes.extend(chip.memory(buffer + read, 1));
        read = (read + 1) % size;
    }
    chip.set_ram(control_block + READ, &read.to_le_bytes());
    bytes
}
