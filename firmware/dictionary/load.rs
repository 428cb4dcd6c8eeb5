//! Reads the object dictionary of a role. The build script generates the node's code from it, and
//! `host-tests/src/tools/generate` generates the EDS file and the reference pages.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;
use toml::{Table, Value};
use zencan_common::device_config::{DefaultValue, DeviceConfig, Object};
use zencan_common::objects::AccessType;

/// Each role with its device type (object 0x1000). The low 16 bits are the device profile, the high
/// 16 bits the kind of device.
pub const ROLES: [(&str, u32); 3] = [
    ("axle", 0x0002_0192),  // CiA 402, servo drive
    ("screw", 0x0002_0192), // CiA 402, servo drive
    ("guard", 0x0002_019A), // CiA 410, inclinometer with two axes of 16 bits
];

/// The object dictionary of one role.
pub struct Dictionary {
    /// The objects in the file, and those that the `CANopen` stack adds.
    pub config: DeviceConfig,
    /// Meanings of objects by index and sub-index, from the key `meaning`. The stack does not know
    /// this key.
    #[allow(dead_code)] // the build script does not use it
    pub meanings: BTreeMap<(u16, u8), String>,
    /// Expressions for the objects that the program writes, from the key `value`.
    values: BTreeMap<(u16, u8), String>,
    /// Names and types of the variables in these expressions, from the table `publish`.
    sources: BTreeMap<String, String>,
}

impl Dictionary {
    /// Returns the code of a function `publish_NAME` for each row of the table `publish`. The
    /// function writes the objects whose `value` uses this row.
    #[allow(dead_code)] // only the build script uses it
    pub fn publish_functions(&self) -> String {
        let mut code = String::new();
        for (name, kind) in &self.sources {
            let mut setters = String::new();
            for ((index, sub), value) in &self.values {
                if takes_from(value, name) {
                    let field = self.field(*index, *sub);
                    let _ = writeln!(setters, "OBJECT{index:X}.set_{field}({value});");
                }
            }
            let _ = writeln!(
                code,
                "pub fn publish_{name}({name}: &{kind}) {{\n{setters}}}"
            );
        }
        code
    }

    /// Checks that each `value` uses exactly one row of `publish` and does not belong to an array.
    fn check_values(&self) -> Result<(), String> {
        for ((index, sub), value) in &self.values {
            let named = |name: &&String| takes_from(value, name);
            let count = self.sources.keys().filter(named).count();
            if count != 1 {
                return Err(format!(
                    "object {index:#06x}:{sub}: `{value}` takes from {count} rows of [publish], not 1"
                ));
            }
            let mut objects = self.config.objects.iter();
            let object = objects.find(|object| object.index == *index);
            if matches!(object.map(|object| &object.object), Some(Object::Array(_))) {
                return Err(format!(
                    "object {index:#06x}:{sub}: an array takes no `value`"
                ));
            }
        }
        Ok(())
    }

    /// Returns the field name that the stack gives to the value of an object in the generated code.
    fn field(&self, index: u16, sub: u8) -> &str {
        let mut objects = self.config.objects.iter();
        let object = objects.find(|object| object.index == index);
        match object.map(|object| &object.object) {
            Some(Object::Record(record)) => {
                let mut subs = record.subs.iter();
                let found = subs.find(|found| found.sub_index == sub);
                found
                    .and_then(|found| found.field_name.as_deref())
                    .unwrap_or("value")
            }
            _ => "value",
        }
    }
}

/// Reads the dictionary of `role` from its file in `folder`, and from the files that the key
/// `include` names.
///
/// # Errors
/// If a file cannot be read, two files have the same key, or the dictionary is not valid.
pub fn load(folder: &Path, role: &str, device_type: u32) -> Result<Dictionary, Box<dyn Error>> {
    let read = |name: &str| -> Result<Table, Box<dyn Error>> {
        let text = std::fs::read_to_string(folder.join(name).with_extension("toml"))?;
        Ok(text.parse()?)
    };
    let mut file = read(role)?;
    let include = file.remove("include").unwrap_or(Value::Array(Vec::new()));
    for name in include.try_into::<Vec<String>>()? {
        merge(&mut file, read(&name)?).map_err(|error| format!("{name}.toml: {error}"))?;
    }
    let meanings = take(&mut file, "meaning");
    let values = take(&mut file, "value");
    let sources = file.remove("publish").unwrap_or(Value::Table(Table::new()));
    let mut config = DeviceConfig::load_from_str(&toml::to_string(&file)?)?;
    for object in &mut config.objects {
        if let Object::Var(var) = &mut object.object {
            // The stack's own definitions say "no profile" (0x1000) and make the heartbeat period
            // (0x1017) read-only.
            match object.index {
                0x1000 => var.default_value = Some(DefaultValue::Integer(device_type.into())),
                0x1017 => var.access_type = AccessType::Rw.into(),
                _ => {}
            }
        }
    }
    let dictionary = Dictionary {
        config,
        meanings,
        values,
        sources: sources.try_into()?,
    };
    dictionary.check_values()?;
    Ok(dictionary)
}

/// Adds `other` to `file`. Tables are merged and arrays are concatenated; no other key may be in
/// both.
fn merge(file: &mut Table, other: Table) -> Result<(), String> {
    for (key, value) in other {
        match (file.get_mut(&key), value) {
            (None, value) => {
                file.insert(key, value);
            }
            (Some(Value::Table(present)), Value::Table(added)) => merge(present, added)?,
            (Some(Value::Array(present)), Value::Array(added)) => present.extend(added),
            (Some(_), _) => return Err(format!("`{key}` is in another file, too")),
        }
    }
    Ok(())
}

/// Returns true if the expression `value` contains a field or method of the variable `source`.
fn takes_from(value: &str, source: &str) -> bool {
    let in_name = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '.';
    let mut places = value.match_indices(source);
    places.any(|(at, _)| {
        !value[..at].ends_with(in_name) && value[at + source.len()..].starts_with('.')
    })
}

/// Removes `key`, which the stack does not know, from all objects, and returns its values by index
/// and sub-index.
fn take(file: &mut Table, key: &str) -> BTreeMap<(u16, u8), String> {
    let mut taken = BTreeMap::new();
    for object in tables(file, "objects") {
        let index = number(object, "index") as u16;
        let mut take = |sub: u8, object: &mut Table| {
            if let Some(Value::String(text)) = object.remove(key) {
                taken.insert((index, sub), text);
            }
        };
        take(0, object);
        for element in tables(object, "subs") {
            take(number(element, "sub_index") as u8, element);
        }
    }
    taken
}

fn tables<'a>(of: &'a mut Table, key: &str) -> impl Iterator<Item = &'a mut Table> {
    let list = of.get_mut(key).and_then(Value::as_array_mut);
    list.into_iter().flatten().filter_map(Value::as_table_mut)
}

fn number(of: &Table, key: &str) -> i64 {
    of.get(key).and_then(Value::as_integer).unwrap_or_default()
}
