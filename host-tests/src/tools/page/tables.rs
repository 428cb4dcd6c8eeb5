//! Tables of the panel: settings, faults and objects of the nodes, from the sources of the EDS
//! files.

use crate::tools::generate::dictionary::model::{Access, Dictionary};
use crate::tools::generate::tables::effect;
use crate::tools::generate::{ReferenceError, dictionaries};
use serde_json::{Value, json};
use tautrack::faults::{self, Reaction};
use tautrack::settings::{Effect, FIRST_OBJECT, TABLE};

/// Returns all tables.
///
/// # Errors
/// [`ReferenceError`] of a dictionary.
pub fn tables() -> Result<Value, ReferenceError> {
    let settings = TABLE.iter().map(|row| {
        json!({
            "index": FIRST_OBJECT + row.key,
            "name": row.name,
            "unit": row.unit,
            "min": row.minimum,
            "max": row.maximum,
            "default": row.default,
            "effect": effect(row.effect),
            "live": row.effect != Effect::Restart,
        })
    });
    let faults = faults::TABLE.iter().map(|row| {
        json!({
            "code": row.code,
            "name": row.name,
            "cause": row.cause,
            "reaction": match row.reaction {
                Reaction::Off => "The drive opens its bridge.",
                Reaction::Brake => "The drive shorts its windings.",
                Reaction::Hold => "The drive ramps to standstill and holds.",
            },
            "clears": row.clears,
            "remedy": row.remedy,
        })
    });
    let roles = dictionaries()?;
    Ok(json!({
        "settings": settings.collect::<Vec<_>>(),
        "faults": faults.collect::<Vec<_>>(),
        "roles": roles.iter().map(role).collect::<Vec<_>>(),
    }))
}

fn role(dictionary: &Dictionary) -> Value {
    let objects = dictionary.objects.iter().flat_map(|object| {
        object.elements().iter().map(move |entry| {
            let name = if object.elements().len() == 1 && entry.sub_index == 0 {
                object.name.clone()
            } else {
                format!("{}: {}", object.name, entry.name)
            };
            json!({
                "index": object.index,
                "sub": entry.sub_index,
                "name": name,
                "type": entry.data_type.code(),
                "writes": entry.access == Access::Rw,
                "meaning": entry.meaning,
            })
        })
    });
    json!({
        "name": dictionary.role,
        "product": dictionary.device.product_code,
        "vendor": dictionary.device.vendor_id,
        "revision": dictionary.device.revision_number,
        "objects": objects.collect::<Vec<_>>(),
    })
}
