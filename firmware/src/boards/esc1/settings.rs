//! Reads the settings of the node from the settings pages of the flash memory.
//!
//! The pages hold the word [`MAGIC`], the number of settings, key and value of each, and the CRC-32
//! of all of these. All are 32-bit words, little-endian. `cargo flash-node --settings` writes them.

use super::crc::crc32;
use crate::roles::{Refusal, refuse};
use tautrack::settings::Settings;

/// First word of written pages: "TTSE".
const MAGIC: u32 = u32::from_le_bytes(*b"TTSE");

unsafe extern "C" {
    /// Start and end of the settings pages, from the link script.
    static _settings_start: u8;
    static _settings_end: u8;
}

/// Returns the stored settings; `None` if the pages hold none.
///
/// # Errors
/// [`Refusal`] if a stored setting is unknown or out of its bounds.
pub fn settings() -> Result<Option<Settings>, Refusal> {
    let Some(entries) = entries(pages()) else {
        defmt::warn!("no settings are stored");
        return Ok(None);
    };
    let mut settings = Settings::default();
    for entry in entries.chunks_exact(8) {
        let (Some(key), Some(value)) = (word(entry, 0), word(entry, 1)) else {
            break;
        };
        let key = u16::try_from(key).map_err(|_| refuse("setting", "unknown key"))?;
        settings
            .set(key, value.cast_signed())
            .map_err(|error| refuse("setting", error))?;
    }
    Ok(Some(settings))
}

fn pages() -> &'static [u8] {
    let start = &raw const _settings_start;
    let length = &raw const _settings_end as usize - start as usize;
    // SAFETY: the link script keeps the pages free of code and data, and nothing writes them while
    // the program runs.
    unsafe { core::slice::from_raw_parts(start, length) }
}

/// Bytes of keys and values in `pages`; `None` unless magic, length and checksum are right.
fn entries(pages: &[u8]) -> Option<&[u8]> {
    let count = word(pages, 1)? as usize;
    let length = count.checked_mul(8)?.checked_add(8)?;
    let (checked, rest) = pages.split_at_checked(length)?;
    (word(pages, 0)? == MAGIC && word(rest, 0)? == crc32(&[checked]))
        .then(|| checked.get(8..))
        .flatten()
}

/// Word number `index` of `bytes`.
fn word(bytes: &[u8], index: usize) -> Option<u32> {
    let bytes = bytes.get(4 * index..)?.first_chunk()?;
    Some(u32::from_le_bytes(*bytes))
}
