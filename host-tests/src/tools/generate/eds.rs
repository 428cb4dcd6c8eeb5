//! Writes an object dictionary as an electronic data sheet (EDS, `CiA` 306), the file format that
//! `CANopen` tools read.

use super::dictionary::model::{
    Access, DefaultValue, Dictionary, Entry, Object, ObjectCode, PdoMapping,
};
use super::setting_objects;
use std::fmt::{Display, Write};

/// Time and date of creation and of modification, which a data sheet must have. They are constants,
/// so that the same dictionary always gives the same file.
const TIME: &str = "12:00AM";
const DATE: &str = "11-01-2026";

/// Returns the text of the EDS file with the name `file`.
pub fn write(file: &str, dictionary: &Dictionary) -> String {
    let mut text = head(file, dictionary);
    let mandatory = |index: u16| matches!(index, 0x1000 | 0x1001 | 0x1018);
    let manufacturer = |index: u16| (0x2000..=0x5fff).contains(&index);
    let indices = || dictionary.objects.iter().map(|object| object.index);
    list(
        &mut text,
        "MandatoryObjects",
        indices().filter(|index| mandatory(*index)),
    );
    list(
        &mut text,
        "OptionalObjects",
        indices().filter(|index| !mandatory(*index) && !manufacturer(*index)),
    );
    let own = indices().filter(|index| manufacturer(*index));
    let mut own: Vec<u16> = own.chain(setting_objects::indices()).collect();
    own.sort_unstable();
    list(&mut text, "ManufacturerObjects", own.into_iter());
    for listed in &dictionary.objects {
        object(&mut text, listed);
    }
    setting_objects::write(&mut text);
    text
}

fn head(file: &str, dictionary: &Dictionary) -> String {
    let device = &dictionary.device;
    let mut text = section("FileInfo").trim_start().to_owned();
    entry(&mut text, "FileName", file);
    entry(&mut text, "FileVersion", 1);
    entry(&mut text, "FileRevision", 0);
    entry(&mut text, "EDSVersion", "4.0");
    entry(&mut text, "Description", &device.name);
    for event in ["Creation", "Modification"] {
        entry(&mut text, &format!("{event}Time"), TIME);
        entry(&mut text, &format!("{event}Date"), DATE);
    }
    entry(&mut text, "CreatedBy", "cargo generate");
    entry(&mut text, "ModifiedBy", "cargo generate");
    text += &section("DeviceInfo");
    entry(&mut text, "VendorName", "tautrack");
    entry(&mut text, "VendorNumber", hex(device.vendor_id));
    entry(&mut text, "ProductName", &device.name);
    entry(&mut text, "ProductNumber", hex(device.product_code));
    entry(&mut text, "RevisionNumber", hex(device.revision_number));
    entry(&mut text, "OrderCode", &dictionary.role);
    for rate in [10, 20, 50, 125, 250, 500, 800, 1_000] {
        entry(
            &mut text,
            &format!("BaudRate_{rate}"),
            u8::from(rate == 1_000),
        );
    }
    let is_master = u8::from(device.nmt_master);
    entry(&mut text, "SimpleBootUpMaster", is_master);
    entry(&mut text, "SimpleBootUpSlave", 1);
    entry(&mut text, "Granularity", 8);
    entry(&mut text, "DynamicChannelsSupported", 0);
    entry(&mut text, "GroupMessaging", 0);
    entry(&mut text, "NrOfRXPDO", device.rpdos);
    entry(&mut text, "NrOfTXPDO", device.tpdos);
    entry(&mut text, "LSS_Supported", 1);
    text += &section("DummyUsage");
    for data_type in 1..=7 {
        entry(&mut text, &format!("Dummy{data_type:04X}"), 0);
    }
    text += &section("Comments");
    entry(&mut text, "Lines", 1);
    let line = "docs/bus.md and docs/settings.md have the units and meanings of the objects.";
    entry(&mut text, "Line1", line);
    text
}

fn list(text: &mut String, name: &str, indices: impl Iterator<Item = u16>) {
    let indices: Vec<u16> = indices.collect();
    *text += &section(name);
    entry(text, "SupportedObjects", indices.len());
    for (number, index) in (1..).zip(indices) {
        entry(text, &number.to_string(), hex(index));
    }
}

fn object(text: &mut String, object: &Object) {
    let index = format!("{:X}", object.index);
    let code = match object.code {
        ObjectCode::Var => return variable(text, &index, &object.entries[0]),
        ObjectCode::Array => "0x8",
        ObjectCode::Record => "0x9",
    };
    *text += &section(&index);
    entry(text, "ParameterName", &object.name);
    entry(text, "ObjectType", code);
    entry(text, "SubNumber", object.entries.len());
    for part in &object.entries {
        variable(text, &format!("{index}sub{:X}", part.sub_index), part);
    }
}

/// Writes a variable, or one entry of a record or array.
fn variable(text: &mut String, section_name: &str, variable: &Entry) {
    *text += &section(section_name);
    entry(text, "ParameterName", &variable.name);
    entry(text, "ObjectType", "0x7");
    let data_type = variable.data_type.code();
    entry(text, "DataType", format_args!("0x{data_type:04X}"));
    let access = match (variable.access, variable.pdo_mapping) {
        (Access::Rw, PdoMapping::Rpdo) => "rww",
        (Access::Rw, PdoMapping::Tpdo) => "rwr",
        (access, _) => access_words(access),
    };
    entry(text, "AccessType", access);
    if let Some([low, high]) = variable.limits {
        entry(text, "LowLimit", low);
        entry(text, "HighLimit", high);
    }
    entry(text, "DefaultValue", default(&variable.default));
    let mappable = variable.pdo_mapping != PdoMapping::None;
    entry(text, "PDOMapping", u8::from(mappable));
}

/// Returns the access type as EDS files spell it for a value that no PDO contains. `rww` is `rw` in
/// PDOs that the node receives, `rwr` in those that it sends.
pub fn access_words(access: Access) -> &'static str {
    match access {
        Access::Ro => "ro",
        Access::Rw => "rw",
        Access::Const => "const",
    }
}

/// Returns a default value as EDS files spell it.
pub fn default(value: &DefaultValue) -> String {
    match value {
        DefaultValue::Number(value) => value.to_string(),
        DefaultValue::Text(value) => value.clone(),
        DefaultValue::Bits { value, add_node_id } => {
            let node = if *add_node_id { "$NODEID+" } else { "" };
            format!("{node}0x{value:08X}")
        }
    }
}

fn hex(value: impl Into<u32>) -> String {
    format!("0x{:X}", value.into())
}

pub(super) fn section(name: &str) -> String {
    format!("\n[{name}]\n")
}

pub(super) fn entry(text: &mut String, name: &str, value: impl Display) {
    let _ = writeln!(text, "{name}={value}"); // writing to a string cannot fail
}
