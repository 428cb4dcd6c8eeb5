//! Writes the objects of the settings as parts of an electronic data sheet. Every role has all of
//! them.

use super::eds::{entry, section};
use super::tables::effect;
use tautrack::settings::{Effect, FIRST_OBJECT, TABLE};

/// Code of the type "integer of 32 bits" (CiA 301).
const INTEGER32: &str = "0x0004";

/// Indices of the objects.
pub fn indices() -> impl Iterator<Item = u16> {
    TABLE.iter().map(|row| FIRST_OBJECT + row.key)
}

/// Writes one section for each setting.
pub fn write(text: &mut String) {
    let mut rows: Vec<_> = TABLE.iter().collect();
    rows.sort_by_key(|row| row.key);
    for row in rows {
        let header = section(&format!("{:X}", FIRST_OBJECT + row.key));
        if row.effect != Effect::Restart {
            // A comment: an entry for it is not in CiA 306. Some readers take none behind the
            // header.
            *text += "\n; takes effect in a drive ";
            *text += effect(row.effect);
        }
        *text += &header;
        entry(text, "ParameterName", row.name);
        entry(text, "ObjectType", "0x7");
        entry(text, "DataType", INTEGER32);
        entry(text, "AccessType", "rw");
        entry(text, "LowLimit", row.minimum);
        entry(text, "HighLimit", row.maximum);
        entry(text, "DefaultValue", row.default);
        entry(text, "PDOMapping", 0);
    }
}
