//! Writes an object dictionary as an electronic data sheet (EDS, `CiA` 306), the file format that
//! `CANopen` tools read.

use super::setting_objects;
use std::fmt::{Display, Write};
use zencan_common::device_config::{
    DataType, DefaultValue, DeviceConfig, Object, ObjectDefinition, PdoDefaultConfig, SubDefinition,
};
use zencan_common::objects::{AccessType, PdoMappable};
use zencan_common::pdo::PdoMapping;

/// Maximum number of objects that one PDO of a node maps. The lists of the `CANopen` stack have
/// room for 64.
const MAPPINGS: u8 = 8;
/// Bit of a COB-ID that marks a PDO as not in use.
const NOT_VALID: u32 = 1 << 31;

/// Name of sub-index 0 of every record and array.
const HIGHEST: &str = "Highest sub-index supported";

/// Returns the text of the EDS file with the name `file`.
pub fn write(file: &str, config: &DeviceConfig) -> String {
    let mut objects: Vec<_> = config.objects.iter().collect();
    objects.sort_by_key(|object| object.index);
    let mut text = head(file, config);
    let mandatory = |index: u16| matches!(index, 0x1000 | 0x1001 | 0x1018);
    let manufacturer = |index: u16| (0x2000..=0x5fff).contains(&index);
    let indices = || objects.iter().map(|object| object.index);
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
    for object in objects {
        match pdo_parameter(object.index, config) {
            Some(pdo) => pdo_object(&mut text, object.index, &pdo),
            None => plain_object(&mut text, object),
        }
    }
    setting_objects::write(&mut text);
    text
}

fn head(file: &str, config: &DeviceConfig) -> String {
    let DeviceConfig {
        device_name,
        identity,
        pdos,
        ..
    } = config;
    let mut text = section("FileInfo").trim_start().to_owned();
    // No dates, so that the same dictionary always gives the same file.
    entry(&mut text, "FileName", file);
    entry(&mut text, "FileVersion", 1);
    entry(&mut text, "FileRevision", 0);
    entry(&mut text, "EDSVersion", "4.0");
    entry(&mut text, "Description", device_name);
    entry(&mut text, "CreatedBy", "cargo generate");
    text += &section("DeviceInfo");
    entry(&mut text, "VendorName", "");
    entry(&mut text, "VendorNumber", hex(identity.vendor_id));
    entry(&mut text, "ProductName", device_name);
    entry(&mut text, "ProductNumber", hex(identity.product_code));
    entry(&mut text, "RevisionNumber", hex(identity.revision_number));
    entry(&mut text, "OrderCode", "");
    for rate in [10, 20, 50, 125, 250, 500, 800, 1_000] {
        entry(
            &mut text,
            &format!("BaudRate_{rate}"),
            u8::from(rate == 1_000),
        );
    }
    entry(&mut text, "SimpleBootUpMaster", 0);
    entry(&mut text, "SimpleBootUpSlave", 1);
    entry(&mut text, "Granularity", 8);
    entry(&mut text, "DynamicChannelsSupported", 0);
    entry(&mut text, "GroupMessaging", 0);
    entry(&mut text, "NrOfRXPDO", pdos.num_rpdo);
    entry(&mut text, "NrOfTXPDO", pdos.num_tpdo);
    entry(&mut text, "LSS_Supported", 1);
    text += &section("DummyUsage");
    for data_type in 1..=7 {
        entry(&mut text, &format!("Dummy{data_type:04X}"), 0);
    }
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

/// A variable, or one element of a record or array.
struct Variable<'a> {
    name: &'a str,
    data_type: DataType,
    access: AccessType,
    default: String,
    mappable: bool,
}

impl Variable<'_> {
    fn write(&self, text: &mut String, section_name: &str) {
        *text += &section(section_name);
        entry(text, "ParameterName", self.name);
        entry(text, "ObjectType", "0x7");
        entry(
            text,
            "DataType",
            format_args!("0x{:04X}", type_code(self.data_type)),
        );
        entry(text, "AccessType", access_words(self.access));
        entry(text, "DefaultValue", &self.default);
        entry(text, "PDOMapping", u8::from(self.mappable));
    }
}

fn plain_object(text: &mut String, object: &ObjectDefinition) {
    let name = object.parameter_name.as_str();
    let index = format!("{:X}", object.index);
    match &object.object {
        Object::Var(var) => Variable {
            name,
            data_type: var.data_type,
            access: var.access_type.0,
            default: default(var.default_value.as_ref()),
            mappable: var.pdo_mapping != PdoMappable::None,
        }
        .write(text, &index),
        Object::Array(array) => {
            let element = |sub: usize| SubDefinition {
                sub_index: sub as u8,
                parameter_name: format!("{name} {sub}"),
                data_type: array.data_type,
                access_type: array.access_type,
                default_value: array
                    .default_value
                    .as_ref()
                    .and_then(|values| values.get(sub - 1).cloned()),
                pdo_mapping: array.pdo_mapping,
                ..SubDefinition::default()
            };
            let subs: Vec<_> = (1..=array.array_size).map(element).collect();
            collection(text, &index, name, "0x8", &subs);
        }
        Object::Record(record) => collection(text, &index, name, "0x9", &record.subs),
    }
}

fn collection(text: &mut String, index: &str, name: &str, kind: &str, subs: &[SubDefinition]) {
    *text += &section(index);
    entry(text, "ParameterName", name);
    entry(text, "ObjectType", kind);
    entry(text, "SubNumber", subs.len() + 1);
    let highest = subs.iter().map(|sub| sub.sub_index).max().unwrap_or(0);
    Variable {
        name: HIGHEST,
        data_type: DataType::UInt8,
        access: AccessType::Const,
        default: highest.to_string(),
        mappable: false,
    }
    .write(text, &format!("{index}sub0"));
    for sub in subs {
        Variable {
            name: &sub.parameter_name,
            data_type: sub.data_type,
            access: sub.access_type.0,
            default: default(sub.default_value.as_ref()),
            mappable: sub.pdo_mapping != PdoMappable::None,
        }
        .write(text, &format!("{index}sub{:X}", sub.sub_index));
    }
}

/// One of the two parameter records of a PDO: communication or mapping.
struct PdoParameter<'a> {
    name: String,
    mapping: bool,
    defaults: Option<&'a PdoDefaultConfig>,
}

/// Returns the PDO parameter at this index, if the index belongs to one.
fn pdo_parameter(index: u16, config: &DeviceConfig) -> Option<PdoParameter<'_>> {
    let (direction, defaults) = match index {
        0x1400..=0x17ff => ("RPDO", &config.pdos.rpdo_defaults),
        0x1800..=0x1bff => ("TPDO", &config.pdos.tpdo_defaults),
        _ => return None,
    };
    let number = usize::from(index & 0x01ff);
    let mapping = index & 0x0200 != 0;
    let kind = if mapping { "mapping" } else { "communication" };
    Some(PdoParameter {
        name: format!("{direction} {} {kind} parameter", number + 1),
        mapping,
        defaults: defaults.get(&number),
    })
}

fn pdo_object(text: &mut String, index: u16, pdo: &PdoParameter) {
    let subs: u8 = if pdo.mapping { MAPPINGS } else { 2 };
    *text += &section(&format!("{index:X}"));
    entry(text, "ParameterName", &pdo.name);
    entry(text, "ObjectType", "0x9");
    entry(text, "SubNumber", subs + 1);
    let mut part = |sub: u8, name: &str, data_type, access, default| {
        let variable = Variable {
            name,
            data_type,
            access,
            default,
            mappable: false,
        };
        variable.write(text, &format!("{index:X}sub{sub}"));
    };
    let (rw, byte, long) = (AccessType::Rw, DataType::UInt8, DataType::UInt32);
    if pdo.mapping {
        let mappings = pdo.defaults.map_or(&[][..], |pdo| &pdo.mappings);
        let number = mappings.len().to_string();
        part(0, "Number of mapped objects", byte, rw, number);
        for sub in 1..=MAPPINGS {
            let mapped = mappings.get(usize::from(sub) - 1);
            let value = mapped.map_or(0, PdoMapping::to_object_value);
            part(sub, &format!("Mapped object {sub}"), long, rw, hex(value));
        }
    } else {
        let transmission_type = pdo.defaults.map_or(0, |pdo| pdo.transmission_type);
        let fixed = AccessType::Const;
        part(0, HIGHEST, byte, fixed, subs.to_string());
        part(1, "COB-ID", long, rw, cob_id(pdo.defaults));
        part(
            2,
            "Transmission type",
            byte,
            rw,
            transmission_type.to_string(),
        );
    }
}

fn cob_id(pdo: Option<&PdoDefaultConfig>) -> String {
    match pdo {
        None => hex(NOT_VALID),
        Some(pdo) => {
            let value = pdo.cob_id | if pdo.enabled { 0 } else { NOT_VALID };
            let node = if pdo.add_node_id { "$NODEID+" } else { "" };
            format!("{node}{}", hex(value))
        }
    }
}

fn type_code(data_type: DataType) -> u16 {
    match data_type {
        DataType::Boolean => 0x01,
        DataType::Int8 => 0x02,
        DataType::Int16 => 0x03,
        DataType::Int32 => 0x04,
        DataType::UInt8 => 0x05,
        DataType::UInt16 => 0x06,
        DataType::UInt32 => 0x07,
        DataType::Real32 => 0x08,
        DataType::VisibleString(_) => 0x09,
        DataType::OctetString(_) => 0x0a,
        DataType::UnicodeString(_) => 0x0b,
        DataType::TimeOfDay => 0x0c,
        DataType::TimeDifference => 0x0d,
        DataType::Domain => 0x0f,
        DataType::Int24 => 0x10,
        DataType::Real64 => 0x11,
        DataType::Int64 => 0x15,
        DataType::UInt24 => 0x16,
        DataType::UInt64 => 0x1b,
    }
}

/// Returns the access type as EDS files spell it.
pub fn access_words(access: AccessType) -> &'static str {
    match access {
        AccessType::Ro => "ro",
        AccessType::Wo => "wo",
        AccessType::Rw => "rw",
        AccessType::Const => "const",
    }
}

/// Returns a default value as EDS files spell it; 0 if there is none.
pub fn default(value: Option<&DefaultValue>) -> String {
    match value {
        None => "0".into(),
        Some(DefaultValue::Integer(value)) => value.to_string(),
        Some(DefaultValue::Float(value)) => value.to_string(),
        Some(DefaultValue::String(value)) => value.clone(),
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
