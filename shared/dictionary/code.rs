//! Generates the code of an object dictionary: the table of all values, the bytes at start that are
//! not 0, with their places, and a constant for each place.

use crate::dictionary::model::{
    Access, DataType, DefaultValue, Dictionary, Entry, Mapped, Object, Pdo, PdoMapping,
};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// Places of values by index and sub-index.
type Places = BTreeMap<(u16, u8), usize>;

/// Returns the code of the dictionary. Objects that `first` has, too, stand at the same places as
/// there.
///
/// # Errors
/// A default does not fit its type.
pub fn generate(dictionary: &Dictionary, first: &Dictionary) -> Result<String, String> {
    let (mut start, mut constants) = (Vec::<u8>::new(), Vec::new());
    let mut places = Places::new();
    let is_first = |object: &&Object| first.objects.iter().any(|it| it.index == object.index);
    let (common, own): (Vec<_>, Vec<_>) = dictionary
        .objects
        .iter()
        .filter(|object| !is_served(object.index))
        .partition(is_first);
    for object in common.iter().chain(&own) {
        for entry in &object.entries {
            let bytes = bytes(entry)?;
            let place = if is_constant(object, entry) {
                find_or_append(&mut constants, &bytes)
            } else {
                start.extend(&bytes);
                start.len() - bytes.len()
            };
            places.insert((object.index, entry.sub_index), place);
        }
    }
    let rows: String = dictionary
        .objects
        .iter()
        .filter(|object| !is_served(object.index))
        .flat_map(|object| object.entries.iter().map(move |entry| (object, entry)))
        .map(|(object, entry)| row(object, entry, &places))
        .collect();
    let not_zero: Vec<_> = (0_u16..)
        .zip(&start)
        .filter(|(_, byte)| **byte != 0)
        .collect();
    let [receive, transmit] = [&dictionary.rpdos, &dictionary.tpdos].map(|pdos| defaults(pdos));
    let mut code = format!(
        "pub static TABLE: Table = Table {{
            rows: &[{rows}],
            constants: &{constants:?},
            receive: &[{receive}],
            transmit: &[{transmit}],
        }};
        pub const BYTES: usize = {};
        pub static START: &[(u16, u8)] = &{not_zero:?};\n",
        start.len()
    );
    for object in common.into_iter().chain(own) {
        fields(object, &places, &mut code);
    }
    code.push_str(&dictionary.publish_functions());
    Ok(code)
}

/// Writes the type of each payload of these roles, once.
///
/// # Errors
/// A PDO maps an object that is not there.
pub fn payloads(dictionaries: &[&Dictionary]) -> Result<String, String> {
    let (mut code, mut known) = (String::new(), BTreeSet::new());
    for dictionary in dictionaries {
        for pdo in dictionary.payloads() {
            if !known.insert(&pdo.payload) {
                continue;
            }
            let _ = write!(code, "payload! {{ {} {} {{", doc(&pdo.meaning), pdo.payload);
            for mapped in &pdo.mappings {
                let (index, sub) = (mapped.index, mapped.sub);
                let objects = dictionary.objects.iter();
                let mut entries = objects
                    .filter(|object| object.index == index)
                    .flat_map(|object| &object.entries);
                let kind = entries
                    .find(|entry| entry.sub_index == sub)
                    .and_then(|entry| type_name(entry.data_type))
                    .ok_or_else(|| format!("{}: no object {index:04x}:{sub}", pdo.payload))?;
                let (high, low) = (index >> 8, (index & 0xff) << 8 | u16::from(sub));
                let (field, meaning) = (&mapped.field, doc(&mapped.meaning));
                let _ = write!(code, "{meaning} {field}: {kind} = {high:#x}_{low:04x},");
            }
            code.push_str("} }\n");
        }
    }
    Ok(code)
}

fn doc(text: &str) -> String {
    format!("#[doc = {text:?}]")
}

/// Whether the node computes the values of an object: those of communication, and what concerns the
/// settings.
fn is_served(index: u16) -> bool {
    matches!(index, 0x1003..=0x1005 | 0x1010..=0x1017 | 0x1029 | 0x1400..0x1c00 | 0x2020..=0x2021)
}

/// Whether a value never changes. The program writes the serial number at start.
fn is_constant(object: &Object, entry: &Entry) -> bool {
    entry.access == Access::Const && (object.index, entry.sub_index) != (0x1018, 4)
}

/// Returns the value of an entry at start.
fn bytes(entry: &Entry) -> Result<Vec<u8>, String> {
    let size = match (entry.data_type, &entry.default) {
        (DataType::VisibleString, DefaultValue::Text(text)) => {
            return Ok(text.clone().into_bytes());
        }
        (DataType::OctetString(length), _) => return Ok(vec![0; length]),
        (DataType::Int8 | DataType::UInt8, _) => 1,
        (DataType::Int16 | DataType::UInt16, _) => 2,
        (DataType::Int32 | DataType::UInt32, _) => 4,
        (other, default) => return Err(format!("{}: {default:?} is no {other}", entry.name)),
    };
    match &entry.default {
        DefaultValue::Number(number) => Ok(number.to_le_bytes()[..size].to_vec()),
        other => Err(format!("{}: {other:?} has no bytes", entry.name)),
    }
}

fn find_or_append(all: &mut Vec<u8>, bytes: &[u8]) -> usize {
    let found = all
        .windows(bytes.len().max(1))
        .position(|window| window == bytes);
    found.unwrap_or_else(|| {
        all.extend(bytes);
        all.len() - bytes.len()
    })
}

/// Row of the table.
fn row(object: &Object, entry: &Entry, places: &Places) -> String {
    let access = match entry.access {
        _ if is_constant(object, entry) => "CONSTANT",
        Access::Rw => "WRITE",
        Access::Ro | Access::Const => "READ",
    };
    let mapping = match entry.pdo_mapping {
        PdoMapping::None => "",
        PdoMapping::Rpdo => ".received()",
        PdoMapping::Tpdo => ".transmitted()",
    };
    let (index, sub) = (object.index, entry.sub_index);
    let (size, place) = (
        bytes(entry).unwrap_or_default().len(),
        places[&(index, sub)],
    );
    format!(
        "Row {{ index: {index:#x}, sub: {sub}, size: {size}, place: {place}, \
         access: Access::{access}{mapping} }},\n"
    )
}

/// Default parameters of the process data.
fn defaults(pdos: &[Option<Pdo>]) -> String {
    let pdos = pdos.iter().map(|pdo| {
        let (id, adds, enabled, kind, mapping) = match pdo {
            None => (0, false, false, 255, Vec::new()),
            Some(pdo) => (
                pdo.cob_id,
                pdo.add_node_id,
                pdo.enabled,
                pdo.transmission_type,
                pdo.mappings.iter().map(Mapped::value).collect(),
            ),
        };
        format!(
            "PdoDefaults {{ id: {id}, adds_node_id: {adds}, enabled: {enabled}, kind: {kind}, \
             mapping: &{mapping:?} }},\n"
        )
    });
    pdos.collect()
}

/// Appends the constants with the places of an object's values to `code`. Elements that differ only
/// in their sub-indices have one, that of the first.
fn fields(object: &Object, places: &Places, code: &mut String) {
    let count = if object.is_uniform() { 1 } else { usize::MAX };
    for entry in object.elements().iter().take(count) {
        if is_constant(object, entry) {
            continue;
        }
        let Some(kind) = type_name(entry.data_type) else {
            continue;
        };
        let (name, place) = (
            entry.place_name(object),
            places[&(object.index, entry.sub_index)],
        );
        let _ = writeln!(
            code,
            "pub const {name}: Field<{kind}> = Field::at({place});"
        );
    }
}

/// Returns the type of a value in Rust; `None` for a text.
fn type_name(data_type: DataType) -> Option<&'static str> {
    Some(match data_type {
        DataType::Int8 => "i8",
        DataType::Int16 => "i16",
        DataType::Int32 => "i32",
        DataType::UInt8 | DataType::OctetString(_) => "u8",
        DataType::UInt16 => "u16",
        DataType::UInt32 => "u32",
        DataType::VisibleString => return None,
    })
}
