//! Generates the code of an object dictionary: for each object a static variable with functions
//! that read and write its values, the statics of the process data, and the table of all objects
//! (`bus::object`).

use std::error::Error;
use std::fmt::Write;
use zencan_common::device_config::{
    ArrayDefinition, DataType, DefaultValue, DeviceConfig, Object, ObjectDefinition, SubDefinition,
    VarDefinition,
};
use zencan_common::objects::AccessType;

/// Returns the code of the dictionary `config`, without the object 0x1010.
///
/// # Errors
/// An object has a type or a default that no node uses.
pub fn generate(config: &DeviceConfig) -> Result<String, Box<dyn Error>> {
    let mut code = process_data(config);
    code.push_str("use crate::bus::object::{Bytes, Constant, Number, Object, Row, Value};\n");
    code.push_str("use zencan_node::common::objects::{AccessType, ObjectCode, PdoMappable};\n");

    let mut objects: Vec<_> = config.objects.iter().collect();
    // `bus::parameters` serves this object: the stack's own does not save when CiA 301 says so.
    objects.retain(|object| object.index != 0x1010);
    objects.sort_by_key(|object| object.index);
    let mut entries = String::new();
    for object in &objects {
        let (index, number) = (object.index, object.index & 0x1ff);
        let data = match index {
            0x1400..0x1600 => format!("&RPDO_COMM_OBJECTS[{number}]"),
            0x1600..0x1800 => format!("&RPDO_MAPPING_OBJECTS[{number}]"),
            0x1800..0x1a00 => format!("&TPDO_COMM_OBJECTS[{number}]"),
            0x1a00..0x1c00 => format!("&TPDO_MAPPING_OBJECTS[{number}]"),
            _ => format!("&{}", define(object, &mut code)?),
        };
        writeln!(entries, "ODEntry {{ index: {index:#x}, data: {data} }},")?;
    }
    let count = objects.len();
    writeln!(
        code,
        "pub static OD_TABLE: [ODEntry; {count}] = [\n{entries}];"
    )?;
    Ok(code)
}

/// Returns the statics of the process data, and the state of the network management that decides
/// whether their parameters can be written.
fn process_data(config: &DeviceConfig) -> String {
    let mut code = String::from(
        "use zencan_node::common::AtomicCell;
        use zencan_node::common::nmt::NmtState;
        use zencan_node::object_dict::ODEntry;
        use zencan_node::pdo::{Pdo, PdoCommObject, PdoDefaults, PdoMappingObject};
        pub static NMT_STATE: AtomicCell<NmtState> = AtomicCell::new(NmtState::Bootup);\n",
    );
    for (name, count, defaults) in [
        ("RPDO", config.pdos.num_rpdo, &config.pdos.rpdo_defaults),
        ("TPDO", config.pdos.num_tpdo, &config.pdos.tpdo_defaults),
    ] {
        let pdos = (0..usize::from(count)).map(|number| {
            let parameters = defaults.get(&number).map_or("DEFAULT".to_owned(), |pdo| {
                let mappings: Vec<_> = pdo
                    .mappings
                    .iter()
                    .map(zencan_common::pdo::PdoMapping::to_object_value)
                    .collect();
                format!(
                    "new({}, {}, {}, {}, {}, {}, &{mappings:?})",
                    pdo.cob_id,
                    pdo.extended,
                    pdo.add_node_id,
                    pdo.enabled,
                    pdo.rtr_disabled,
                    pdo.transmission_type,
                )
            });
            format!("Pdo::new_with_defaults(&OD_TABLE, &NMT_STATE, &PdoDefaults::{parameters}),\n")
        });
        let pdos: String = pdos.collect();
        let _ = writeln!(code, "pub static {name}S: [Pdo; {count}] = [{pdos}];");
        for (kind, of) in [("COMM", "PdoCommObject"), ("MAPPING", "PdoMappingObject")] {
            let objects = (0..count).map(|number| format!("{of}::new(&{name}S[{number}]), "));
            let objects: String = objects.collect();
            let _ = writeln!(
                code,
                "pub static {name}_{kind}_OBJECTS: [{of}; {count}] = [{objects}];"
            );
        }
    }
    code
}

/// Appends the static variable of an object to `code`. Returns the object's value in the table.
fn define(object: &ObjectDefinition, code: &mut String) -> Result<String, Box<dyn Error>> {
    let name = format!("{:X}", object.index);
    let (kind, subs) = match &object.object {
        Object::Var(var) => ("Var", vec![value(var)]),
        Object::Array(array) => ("Array", elements(array)),
        Object::Record(record) => ("Record", record.subs.clone()),
    };
    let (mut fields, mut values, mut functions) = (String::new(), String::new(), String::new());
    let mut rows = String::new();
    let highest = subs.iter().map(|sub| sub.sub_index).max().unwrap_or(0);
    if highest > 0 {
        let sub = SubDefinition {
            access_type: AccessType::Const.into(),
            ..SubDefinition::default()
        };
        rows.push_str(&row(
            &sub,
            &format!("Value::Bytes(&Constant(&[{highest}]))"),
        )?);
    }
    for sub in &subs {
        let unnamed = format!("sub{}", sub.sub_index);
        let field = sub.field_name.as_deref().unwrap_or(&unnamed);
        let (variable, place) = storage(sub, &format!("OBJECT{name}.{field}"))?;
        rows.push_str(&row(sub, &place)?);
        let Some((kind, holder, start)) = variable else {
            continue;
        };
        if !matches!(object.object, Object::Array(_)) {
            write!(fields, "pub {field}: {holder}, ")?;
            write!(values, "{field}: {start}, ")?;
            let setter = format!("pub fn set_{field}(&self, value: {kind})");
            writeln!(functions, "{setter} {{ self.{field}.store(value) }}")?;
            if holder.starts_with("Number") {
                let getter = format!("pub fn get_{field}(&self) -> {kind}");
                writeln!(functions, "{getter} {{ self.{field}.load() }}")?;
            }
        } else if sub.sub_index == highest {
            write!(fields, "pub array: [{holder}; {highest}], ")?;
            write!(values, "array: [const {{ {start} }}; {highest}], ")?;
            writeln!(
                functions,
                "pub fn set(&self, index: usize, value: {kind}) {{
                    if let Some(element) = self.array.get(index) {{ element.store(value) }}
                }}"
            )?;
        }
    }
    writeln!(
        code,
        "pub struct Object{name} {{ {fields} }}
        impl Object{name} {{ {functions} }}
        pub static OBJECT{name}: Object{name} = Object{name} {{ {values} }};"
    )?;
    Ok(format!(
        "Object {{ code: ObjectCode::{kind}, rows: &[{rows}] }}"
    ))
}

/// Row of a sub-index whose value is at `place`.
fn row(sub: &SubDefinition, place: &str) -> Result<String, Box<dyn Error>> {
    let (access, mapping) = (sub.access_type.0, sub.pdo_mapping);
    let data_type = match sub.data_type {
        DataType::Int8 => 2,
        DataType::Int16 => 3,
        DataType::Int32 => 4,
        DataType::UInt8 => 5,
        DataType::UInt16 => 6,
        DataType::UInt32 => 7,
        DataType::VisibleString(_) => 9,
        DataType::OctetString(_) => 10,
        other => return Err(format!("no object has the type {other:?}").into()),
    };
    Ok(format!(
        "Row {{ number: {}, access: AccessType::{access:?}, mapping: PdoMappable::{mapping:?}, \
         data_type: {data_type}, value: {place} }}, ",
        sub.sub_index
    ))
}

/// The only sub-index of an object with one value.
fn value(var: &VarDefinition) -> SubDefinition {
    SubDefinition {
        field_name: Some("value".to_owned()),
        data_type: var.data_type,
        access_type: var.access_type,
        default_value: var.default_value.clone(),
        pdo_mapping: var.pdo_mapping,
        ..SubDefinition::default()
    }
}

/// The sub-indices of an array.
fn elements(array: &ArrayDefinition) -> Vec<SubDefinition> {
    let element = |index| SubDefinition {
        sub_index: index as u8 + 1,
        field_name: Some(format!("array[{index}]")),
        data_type: array.data_type,
        access_type: array.access_type,
        pdo_mapping: array.pdo_mapping,
        ..SubDefinition::default()
    };
    (0..array.array_size).map(element).collect()
}

/// Type of a value, type of the variable that holds it, and the variable's start value.
type Variable = (String, String, String);

/// Returns the variable with the value of `sub`, if it needs one, and where the row of the table
/// finds the value. The path of the variable is `path`.
fn storage(sub: &SubDefinition, path: &str) -> Result<(Option<Variable>, String), Box<dyn Error>> {
    let kind = match sub.data_type {
        DataType::Int8 => "i8",
        DataType::UInt8 => "u8",
        DataType::Int16 => "i16",
        DataType::UInt16 => "u16",
        DataType::Int32 => "i32",
        DataType::UInt32 => "u32",
        DataType::VisibleString(_) => {
            let Some(DefaultValue::String(text)) = &sub.default_value else {
                return Err("a text needs a default".into());
            };
            return Ok((
                None,
                format!("Value::Bytes(&Constant({text:?}.as_bytes()))"),
            ));
        }
        DataType::OctetString(length) => {
            let kind = format!("[u8; {length}]");
            let holder = format!("Bytes<{length}>");
            let start = "Bytes::zeros()".to_owned();
            return Ok((
                Some((kind, holder, start)),
                format!("Value::Bytes(&{path})"),
            ));
        }
        other => return Err(format!("no object has the type {other:?}").into()),
    };
    let start = match &sub.default_value {
        None => 0,
        Some(DefaultValue::Integer(value)) => *value as u32,
        Some(other) => return Err(format!("{other:?} is no {kind}").into()),
    };
    let variable = (
        kind.to_owned(),
        format!("Number<{kind}>"),
        format!("Number::new({start})"),
    );
    Ok((Some(variable), format!("{path}.place()")))
}
