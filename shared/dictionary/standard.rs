//! The objects that every node has and that no file defines: its identity, its heartbeat, and the
//! parameters of its PDOs (`CiA` 301).

use super::model::{
    Access, DataType, DefaultValue, Dictionary, Entry, Mapped, Object, ObjectCode, Pdo,
};
use DataType::{UInt8, UInt16, UInt32, VisibleString};
use DefaultValue::{Bits, Number, Text};

/// Maximum number of entries that one PDO maps: so many bytes are in a frame.
const MAPPINGS: u8 = 8;
/// Bit of a COB-ID that marks a PDO as not in use.
const NOT_VALID: u32 = 1 << 31;
/// Bit of a COB-ID that marks a PDO as not sent on request.
const NO_REMOTE_FRAMES: u32 = 1 << 30;
/// Profile of the guard (CiA 410).
const INCLINOMETER: u32 = 410;
/// Index of the first transmit PDO.
const FIRST_TRANSMIT: u16 = 0x1800;

/// Returns the standard objects of a node with this device and these PDOs.
pub fn objects(dictionary: &Dictionary) -> Vec<Object> {
    let device = &dictionary.device;
    let text = |text: &String| Text(text.clone());
    let part = |sub, name, field: &str, value: u32| Entry {
        field: field.to_owned(),
        ..Entry::new(sub, name, UInt32, Access::Const, Number(value.into()))
    };
    let identity = vec![
        part(1, "Vendor ID", "vendor_id", device.vendor_id),
        part(2, "Product Code", "product_code", device.product_code),
        part(3, "Revision Number", "revision", device.revision_number),
        // The program writes it at start.
        part(4, "Serial Number", "serial", 0),
    ];
    let device_type = Number(device.profile.into());
    let period = Number(device.heartbeat_period.into());
    let hardware = text(&device.hardware_version);
    let software = text(&device.software_version);
    // The guard sends SYNC.
    let is_master = device.profile & 0xffff == INCLINOMETER;
    let sync = Number(if is_master { 0x4000_0080 } else { 0x80 });
    let watched = vec![
        Entry::new(1, "Guard", UInt32, Access::Ro, Number(0)),
        Entry::new(2, "Client", UInt32, Access::Rw, Number(0)),
    ];
    let behaviour = vec![Entry::new(
        1,
        "Communication error",
        UInt8,
        Access::Const,
        Number(1),
    )];
    let (fixed, name) = (Access::Const, text(&device.name));
    let mut objects = vec![
        variable(0x1000, "Device Type", UInt32, fixed, device_type),
        variable(0x1001, "Error Register", UInt8, Access::Ro, Number(0)),
        history(),
        variable(0x1005, "COB-ID SYNC", UInt32, fixed, sync),
        variable(
            0x1008,
            "Manufacturer Device Name",
            VisibleString,
            fixed,
            name,
        ),
        variable(
            0x1009,
            "Manufacturer Hardware Version",
            VisibleString,
            fixed,
            hardware,
        ),
        variable(
            0x100A,
            "Manufacturer Software Version",
            VisibleString,
            fixed,
            software,
        ),
        variable(
            0x1014,
            "COB-ID EMCY",
            UInt32,
            Access::Ro,
            Bits {
                value: 0x80,
                add_node_id: true,
            },
        ),
        Object::with_elements(
            0x1016,
            "Consumer Heartbeat Time",
            ObjectCode::Array,
            watched,
        ),
        variable(
            0x1017,
            "Heartbeat Producer Time (ms)",
            UInt16,
            Access::Rw,
            period,
        ),
        Object::with_elements(0x1018, "Identity", ObjectCode::Record, identity),
        Object::with_elements(0x1029, "Error Behaviour", ObjectCode::Array, behaviour),
    ];
    for (direction, first, pdos) in [
        ("RPDO", 0x1400, &dictionary.rpdos),
        ("TPDO", 0x1800, &dictionary.tpdos),
    ] {
        for (number, pdo) in (0..).zip(pdos) {
            let name = format!("{direction} {}", number + 1);
            objects.push(communication(first + number, &name, pdo.as_ref()));
            objects.push(mapping(first + 0x200 + number, &name, pdo.as_ref()));
        }
    }
    objects
}

/// The error history, whose sub-index 0 can be written.
fn history() -> Object {
    let count = Entry::new(0, "Number of errors", UInt8, Access::Rw, Number(0));
    let errors = (1..=8).map(|sub| {
        let name = format!("Error {sub}");
        Entry::new(sub, &name, UInt32, Access::Ro, Number(0))
    });
    Object {
        index: 0x1003,
        name: "Pre-defined Error Field".to_owned(),
        code: ObjectCode::Array,
        entries: std::iter::once(count).chain(errors).collect(),
    }
}

fn variable(
    index: u16,
    name: &str,
    data_type: DataType,
    access: Access,
    default: DefaultValue,
) -> Object {
    let entry = Entry {
        field: "value".to_owned(),
        ..Entry::new(0, name, data_type, access, default)
    };
    Object {
        index,
        name: name.to_owned(),
        code: ObjectCode::Var,
        entries: vec![entry],
    }
}

/// Communication parameter of the PDO with this name.
fn communication(index: u16, name: &str, pdo: Option<&Pdo>) -> Object {
    let transmits = index >= FIRST_TRANSMIT;
    let cob_id = pdo.map_or(NOT_VALID, |pdo| {
        pdo.cob_id | if pdo.enabled { 0 } else { NOT_VALID }
    });
    let cob_id = cob_id | if transmits { NO_REMOTE_FRAMES } else { 0 };
    let cob_id = Bits {
        value: cob_id,
        add_node_id: pdo.is_some_and(|pdo| pdo.add_node_id),
    };
    let transmission_type = Number(pdo.map_or(255, |pdo| pdo.transmission_type).into());
    let mut elements = vec![
        Entry::new(1, "COB-ID", UInt32, Access::Rw, cob_id),
        Entry::new(2, "Transmission type", UInt8, Access::Rw, transmission_type),
    ];
    if transmits {
        for (sub, name) in [(3, "Inhibit time (0.1 ms)"), (5, "Event timer (ms)")] {
            elements.push(Entry::new(sub, name, UInt16, Access::Rw, Number(0)));
        }
    }
    let name = format!("{name} communication parameter");
    Object::with_elements(index, &name, ObjectCode::Record, elements)
}

/// Mapping parameter of the PDO with this name. Its sub-index 0 can be written.
fn mapping(index: u16, name: &str, pdo: Option<&Pdo>) -> Object {
    let mappings = pdo.map_or(&[][..], |pdo| &pdo.mappings);
    let count = Number(mappings.len() as i64);
    let count = Entry::new(0, "Number of mapped objects", UInt8, Access::Rw, count);
    let mapped = (1..=MAPPINGS).map(|sub| {
        let mapped = mappings.get(usize::from(sub) - 1);
        let value = Bits {
            value: mapped.map_or(0, Mapped::value),
            add_node_id: false,
        };
        Entry::new(
            sub,
            &format!("Mapped object {sub}"),
            UInt32,
            Access::Rw,
            value,
        )
    });
    Object {
        index,
        name: format!("{name} mapping parameter"),
        code: ObjectCode::Record,
        entries: std::iter::once(count).chain(mapped).collect(),
    }
}
