//! Reads the object dictionary of a role. The build script generates the node's code from it, and
//! `host-tests/src/tools/generate` generates the EDS file and the reference pages.
//!
//! A role has a file with its name, and this file may include others. [`model`] is what they
//! become, `standard` adds the objects that every node has, and `publish` writes the functions that
//! set the objects of the program. Every error names the file, the object and the key.

pub mod model;
mod publish;
mod standard;

use model::{
    Access, DataType, DefaultValue, Device, Dictionary, Entry, Object, ObjectCode, Pdo, PdoMapping,
};
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::fs;
use std::num::NonZeroU8;
use std::path::Path;
use toml::{Table, Value};

/// Error of a key that may be in one file alone.
const IN_ANOTHER: &str = "is in another file, too";

/// The roles of nodes.
pub const ROLES: [&str; 3] = ["axle", "screw", "guard"];

/// Reads the dictionary of `role` from its file in `folder`, and from the files that the key
/// `include` names.
///
/// # Errors
/// If a file cannot be read, lacks a key, has an unknown key or a wrong value, or if two files
/// define the same thing.
pub fn load(folder: &Path, role: &str) -> Result<Dictionary, String> {
    let mut file = Keys::read(folder, role)?;
    let device: Device = file.required("device")?;
    let included: Vec<String> = file.optional("include")?.unwrap_or_default();
    let mut files = vec![file];
    for name in included {
        files.push(Keys::read(folder, &name)?);
    }

    let mut dictionary = Dictionary {
        role: role.to_owned(),
        rpdos: vec![None; device.rpdos.into()],
        tpdos: vec![None; device.tpdos.into()],
        device,
        objects: Vec::new(),
        publish: BTreeMap::new(),
    };
    for file in &mut files {
        add_pdos(file, "rpdo", &mut dictionary.rpdos)?;
        add_pdos(file, "tpdo", &mut dictionary.tpdos)?;
        for (name, kind) in file.named("publish")? {
            if dictionary.publish.insert(name.clone(), kind).is_some() {
                return Err(file.wrong(&format!("publish.{name}"), IN_ANOTHER));
            }
        }
    }
    dictionary.objects = standard::objects(&dictionary);
    for mut file in files {
        for object in file.tables("objects", "an object")? {
            add_object(object, &mut dictionary)?;
        }
        file.finish()?;
    }
    dictionary.objects.sort_by_key(|object| object.index);
    Ok(dictionary)
}

/// Moves the PDOs below `key` to their numbers in `pdos`.
fn add_pdos(file: &mut Keys, key: &str, pdos: &mut [Option<Pdo>]) -> Result<(), String> {
    let count = pdos.len();
    for (number, pdo) in file.named(key)? {
        let key = format!("{key}.{number}");
        let slot = number.parse().ok().and_then(|at: usize| pdos.get_mut(at));
        let slot = slot.ok_or_else(|| file.wrong(&key, &format!("must be below {count}")))?;
        if slot.replace(pdo).is_some() {
            return Err(file.wrong(&key, IN_ANOTHER));
        }
    }
    Ok(())
}

/// Reads one object and adds it to the dictionary.
fn add_object(mut keys: Keys, dictionary: &mut Dictionary) -> Result<(), String> {
    let index: u16 = keys.required("index")?;
    keys.place = format!("{}: object {index:#06x}", keys.file);
    let place = keys.place.clone();
    let mut known = dictionary.objects.iter();
    if known.any(|object| object.index == index) {
        return Err(keys.wrong("index", "is used twice"));
    }
    let name: String = keys.required("parameter_name")?;
    let code = keys.required("object_type")?;
    let object = match code {
        ObjectCode::Var => Object {
            index,
            code,
            entries: vec![entry(keys, 0, &name, "value")?],
            name,
        },
        ObjectCode::Array if keys.table.contains_key("array_size") => {
            let size: NonZeroU8 = keys.required("array_size")?;
            let element = entry(keys, 1, &name, "array")?;
            if element.value.is_some() {
                return Err(format!("{place}: an array takes no `value`"));
            }
            let elements = (1..=size.get()).map(|sub_index| Entry {
                sub_index,
                name: format!("{name} {sub_index}"),
                field: Entry::numbered(sub_index),
                ..element.clone()
            });
            Object::with_elements(index, &name, code, elements.collect())
        }
        ObjectCode::Array | ObjectCode::Record => {
            Object::with_elements(index, &name, code, elements(keys)?)
        }
    };
    if code == ObjectCode::Array {
        let mut types = object.elements().iter().map(|element| element.data_type);
        let first = types.next();
        if types.any(|data_type| Some(data_type) != first) {
            return Err(format!("{place}: the elements of an array have one type"));
        }
    }
    for entry in &object.entries {
        if let Some(value) = &entry.value {
            let (sub, count) = (entry.sub_index, dictionary.sources_of(value));
            if count != 1 {
                return Err(format!(
                    "{place}:{sub}: `value` takes from {count} rows of `publish`, not 1: {value}"
                ));
            }
        }
    }
    dictionary.objects.push(object);
    Ok(())
}

/// Reads the elements of a record, or of an array whose elements have names of their own.
fn elements(mut keys: Keys) -> Result<Vec<Entry>, String> {
    let mut elements: Vec<Entry> = Vec::new();
    for mut element in keys.tables("subs", "an element")? {
        let sub_index: u8 = element.required("sub_index")?;
        element.place = format!("{}:{sub_index}", keys.place);
        let used = |other: &Entry| other.sub_index == sub_index;
        if sub_index == 0 || elements.iter().any(used) {
            return Err(element.wrong("sub_index", "is used twice"));
        }
        let name: String = element.required("parameter_name")?;
        let field: String = element.required("field_name")?;
        elements.push(entry(element, sub_index, &name, &field)?);
    }
    keys.finish()?;
    Ok(elements)
}

/// Reads what variables, arrays and the elements of records have in common.
fn entry(mut keys: Keys, sub_index: u8, name: &str, field: &str) -> Result<Entry, String> {
    let data_type: DataType = keys.required("data_type")?;
    let default = match (keys.optional("default_value")?, data_type.bounds()) {
        (None, Some(_)) => DefaultValue::Number(0),
        (Some(Value::Integer(number)), Some(bounds)) if bounds.contains(&number) => {
            DefaultValue::Number(number)
        }
        (Some(Value::String(text)), None) => DefaultValue::Text(text),
        (None, None) => return Err(keys.wrong("default_value", "is missing")),
        (Some(other), _) => {
            return Err(keys.wrong("default_value", &format!("is {other}, not {data_type}")));
        }
    };
    let limits: Option<[i64; 2]> = keys.optional("limits")?;
    if let Some([low, high]) = limits {
        let inside = |value: &i64| data_type.bounds().is_some_and(|all| all.contains(value));
        let accepts =
            matches!(default, DefaultValue::Number(number) if (low..=high).contains(&number));
        if !(inside(&low) && inside(&high) && accepts) {
            let what = format!("[{low}, {high}] are not around the default in {data_type}");
            return Err(keys.wrong("limits", &what));
        }
    }
    let access: Access = keys.required("access_type")?;
    let pdo_mapping: PdoMapping = keys.required("pdo_mapping")?;
    let entry = Entry {
        field: field.to_owned(),
        pdo_mapping,
        limits,
        meaning: keys.optional("meaning")?,
        value: keys.optional("value")?,
        ..Entry::new(sub_index, name, data_type, access, default)
    };
    keys.finish()?;
    Ok(entry)
}

/// The keys of a table that were not read yet.
struct Keys {
    file: String,
    /// The table in the words of an error.
    place: String,
    table: Table,
}

impl Keys {
    /// Reads a file.
    fn read(folder: &Path, name: &str) -> Result<Self, String> {
        let file = format!("{name}.toml");
        let text = fs::read_to_string(folder.join(&file)).map_err(|e| format!("{file}: {e}"))?;
        let table = text.parse().map_err(|error| format!("{file}: {error}"))?;
        Ok(Self {
            place: file.clone(),
            file,
            table,
        })
    }

    fn wrong(&self, key: &str, what: &str) -> String {
        format!("{}: `{key}` {what}", self.place)
    }

    fn read_value<T: DeserializeOwned>(&self, key: &str, value: Value) -> Result<T, String> {
        value.try_into().map_err(|error| {
            let error = error.to_string().trim_end().replace('\n', " ");
            self.wrong(key, &format!("is wrong: {error}"))
        })
    }

    fn optional<T: DeserializeOwned>(&mut self, key: &str) -> Result<Option<T>, String> {
        let value = self.table.remove(key);
        value.map(|value| self.read_value(key, value)).transpose()
    }

    fn required<T: DeserializeOwned>(&mut self, key: &str) -> Result<T, String> {
        let value = self.optional(key)?;
        value.ok_or_else(|| self.wrong(key, "is missing"))
    }

    /// Returns the names and values in the table at `key`; none if the key is missing.
    fn named<T: DeserializeOwned>(&mut self, key: &str) -> Result<Vec<(String, T)>, String> {
        let table: Table = self.optional(key)?.unwrap_or_default();
        let read = |(name, value)| {
            let value = self.read_value(&format!("{key}.{name}"), value)?;
            Ok((name, value))
        };
        table.into_iter().map(read).collect()
    }

    /// Returns the tables at `key`, each of which is `what`; none if the key is missing.
    fn tables(&mut self, key: &str, what: &str) -> Result<Vec<Self>, String> {
        let tables: Vec<Table> = self.optional(key)?.unwrap_or_default();
        let keys = tables.into_iter().map(|table| Self {
            file: self.file.clone(),
            place: format!("{}: {what}", self.place),
            table,
        });
        Ok(keys.collect())
    }

    /// Checks that all keys were read.
    fn finish(self) -> Result<(), String> {
        match self.table.keys().next() {
            None => Ok(()),
            Some(key) => Err(self.wrong(key, "is no known key")),
        }
    }
}
