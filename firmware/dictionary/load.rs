//! Reads the object dictionary of a role: the build script makes the node of it, and `host-tests/src/tools/generate` its
//! EDS file and its pages.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;
use toml::{Table, Value};
use zencan_common::device_config::{DefaultValue, DeviceConfig, Object};
use zencan_common::objects::AccessType;

/// Role, and its device type (0x1000): the device profile in the low half, its kind of device in the high half.
pub const ROLES: [(&str, u32); 3] = [
    ("axle", 0x0002_0192),  // CiA 402, servo drive
    ("screw", 0x0002_0192), // the same
    ("guard", 0x0002_019A), // CiA 410, two axes of 16 bit
];

/// The dictionary of one role.
pub struct Dictionary {
    /// Its objects, and those that the stack adds.
    pub config: DeviceConfig,
    /// What an object means, by index and sub-index: the key `meaning`, which the stack does not know.
    #[allow(dead_code)] // the build script has no use for it
    pub meanings: BTreeMap<(u16, u8), String>,
    /// Expressions of the objects that the program writes: the key `value`.
    values: BTreeMap<(u16, u8), String>,
    /// Name and type of what the expressions take their values from: the table `publish`.
    sources: BTreeMap<String, String>,
}

impl Dictionary {
    /// A function `publish_NAME` for each row of `publish`, which writes the objects with a value from it.
    #[allow(dead_code)] // for the build script alone
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

    /// Each `value` takes from one row of `publish`, and belongs to an object with one setter.
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

    /// What the stack calls the value of an object in its code.
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

/// The dictionary of `role` in `folder`.
///
/// # Errors
/// When the file cannot be read or is no dictionary.
pub fn load(folder: &Path, role: &str, device_type: u32) -> Result<Dictionary, Box<dyn Error>> {
    let text = std::fs::read_to_string(folder.join(role).with_extension("toml"))?;
    let mut file: Table = text.parse()?;
    let meanings = take(&mut file, "meaning");
    let values = take(&mut file, "value");
    let sources = file.remove("publish").unwrap_or(Value::Table(Table::new()));
    let mut config = DeviceConfig::load_from_str(&toml::to_string(&file)?)?;
    for object in &mut config.objects {
        if let Object::Var(var) = &mut object.object {
            // The stack fixes both: it would say "no profile", and never let a client set the heartbeat.
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

/// Whether the expression `value` names `source` and a field or method of it.
fn takes_from(value: &str, source: &str) -> bool {
    let in_name = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '.';
    let mut places = value.match_indices(source);
    places.any(|(at, _)| {
        !value[..at].ends_with(in_name) && value[at + source.len()..].starts_with('.')
    })
}

/// Takes `key`, which the stack does not know, out of all objects.
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
