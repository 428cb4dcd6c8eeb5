//! Tests that the PDO mappings in the object dictionaries match the codecs of `tautrack::bus::pdo`,
//! so that each node reads what another one sends. Also tests that the EDS files in docs/eds match
//! the objects of a running node.

mod node;

use std::path::Path;

use node::{MOTOR, Node, ROLES, settings};
use tautrack::bus::network::function::{RPDO, TPDO};
use tautrack::bus::pdo::{
    DriveMotion, DriveStatus, GuardMargins, GuardMotion, GuardPassed, GuardPosition, GuardState,
    OperatorCommand, PositionSetPoint, TorqueOffset, TorqueSetPoint, VelocitySetPoint,
};
use tautrack::can::Frame;
use tautrack::link::Sensors;
use tautrack::settings::FIRST_OBJECT;

const NODE: u16 = 9;

/// Reads an object of up to four bytes from the running node.
fn read(node: &mut Node, index: u16, sub: u8) -> u32 {
    read_sized(node, index, sub).0
}

/// Reads an object of up to four bytes; returns its value and its length in bytes.
fn read_sized(node: &mut Node, index: u16, sub: u8) -> (u32, usize) {
    let [low, high] = index.to_le_bytes();
    let request = Frame::new(0x600 + NODE, &[0x40, low, high, sub, 0, 0, 0, 0]).expect("a frame");
    let sensors = Sensors {
        supply_voltage: 24.0,
        ..Sensors::default()
    };
    let answers = node.step(sensors, &[request]).frames;
    let answer = answers
        .iter()
        .find(|frame| frame.id() == 0x580 + NODE)
        .expect("an answer");
    let command = answer.data()[0];
    assert_eq!(command & 0xf3, 0x43, "{index:#x}:{sub} is not readable");
    let value = u32::from_le_bytes(answer.data()[4..].try_into().expect("eight bytes"));
    (value, usize::from(4 - (command >> 2 & 3)))
}

/// Object of an EDS file, for node [`NODE`].
struct Entry {
    index: u16,
    sub: u8,
    data_type: u16,
    default: u32,
    writable: bool,
}

/// Returns the entries of an EDS file, without strings.
fn entries(eds: &str) -> Vec<Entry> {
    let number = |text: &str| match text.strip_prefix("0x") {
        Some(digits) => i64::from_str_radix(digits, 16).expect("a number"),
        None => text.parse().expect("a number"),
    };
    let mut entries = Vec::new();
    for section in eds.split("\n[").skip(1) {
        let (name, rest) = section.split_once(']').expect("a section");
        let (index, sub) = name.split_once("sub").unwrap_or((name, "0"));
        let (Ok(index), Ok(sub)) = (u16::from_str_radix(index, 16), u8::from_str_radix(sub, 16))
        else {
            continue;
        };
        let value = |key: &str| rest.lines().find_map(|line| line.strip_prefix(key));
        let (Some(data_type), Some(default)) = (value("DataType="), value("DefaultValue=")) else {
            continue;
        };
        let data_type = number(data_type) as u16;
        let (node, default) = match default.strip_prefix("$NODEID+") {
            Some(rest) => (i64::from(NODE), rest),
            None => (0, default),
        };
        // Strings are compared nowhere.
        if !matches!(data_type, 9 | 10) {
            entries.push(Entry {
                index,
                sub,
                data_type,
                default: (number(default) + node) as u32,
                writable: value("AccessType=").is_some_and(|access| access.starts_with("rw")),
            });
        }
    }
    entries
}

fn assert_map(node: &mut Node, communication: u16, identifier: u16, mapping: &[u32]) {
    let parameter = communication + 0x200;
    assert_eq!(
        read(node, communication, 1) & 0x8000_07ff,
        u32::from(identifier),
        "COB-ID {communication:#x}"
    );
    let mapped: Vec<u32> = (1..=read(node, parameter, 0))
        .map(|sub| read(node, parameter, sub as u8))
        .collect();
    assert_eq!(mapped, mapping, "mapping {parameter:#x}");
}

fn started(role: &'static str) -> Node {
    let mut node = Node::host(role);
    // Without a motor, a drive gets no current samples, and its watchdog resets it.
    let motor = (role != "guard").then_some(MOTOR);
    assert_eq!(node.start(&settings(i32::from(NODE)), motor), "");
    node
}

#[test]
fn nodes_hold_what_their_data_sheets_say() {
    for role in ROLES {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../docs/eds/{role}.eds"));
        let entries = entries(&std::fs::read_to_string(path).expect("the data sheet"));
        assert!(entries.len() > 70, "{role}: {}", entries.len());
        let mut node = started(role);
        for entry in entries {
            let Entry {
                index,
                sub,
                data_type,
                default,
                writable,
            } = entry;
            let given = settings(i32::from(NODE));
            let mut given = given.iter().filter(|(key, _)| FIRST_OBJECT + key == index);
            let default = given.next().map_or(default, |(_, value)| *value as u32);
            // Values that the stack or the node computes, or that the settings define, differ from
            // the dictionary's default.
            let running = index >= 0x2000 && !writable
                || matches!(
                    (index, sub),
                    (0x1001 | 0x1017, _) | (0x1016, 1) | (0x1018, 4)
                )
                || matches!(index, 0x6065 | 0x6067 | 0x6068 | 0x607d | 0x6087 | 0x6098)
                || (role, index, sub) == ("screw", 0x1403, 1);
            if index == 0x1003 && sub > 0 {
                continue; // there is no error
            }
            let size = [0, 1, 1, 2, 4, 1, 2, 4][usize::from(data_type)];
            let (value, answered) = read_sized(&mut node, index, sub);
            assert_eq!(answered, size, "{role} {index:#x}:{sub} has another length");
            let kept = u32::MAX >> (32 - 8 * size);
            assert!(
                running || value == default & kept,
                "{role} {index:#x}:{sub} is {value:#x}, its data sheet says {default:#x}"
            );
        }
    }
}

#[test]
fn drives_map_what_the_codecs_say() {
    for role in ["axle", "screw"] {
        let mut node = started(role);
        assert_map(&mut node, 0x1400, RPDO[0] + NODE, PositionSetPoint::MAPPING);
        assert_map(&mut node, 0x1401, RPDO[1] + NODE, VelocitySetPoint::MAPPING);
        assert_map(&mut node, 0x1402, RPDO[2] + NODE, TorqueOffset::MAPPING);
        if role == "axle" {
            assert_map(&mut node, 0x1403, RPDO[3] + NODE, TorqueSetPoint::MAPPING);
        }
        assert_map(&mut node, 0x1800, TPDO[0] + NODE, DriveMotion::MAPPING);
        assert_map(&mut node, 0x1801, TPDO[1] + NODE, DriveStatus::MAPPING);
    }
}

#[test]
fn guard_maps_what_the_codecs_say() {
    let mut node = started("guard");
    assert_map(&mut node, 0x1400, RPDO[0] + NODE, OperatorCommand::MAPPING);
    assert_map(&mut node, 0x1800, TPDO[0] + NODE, GuardMotion::MAPPING);
    assert_map(&mut node, 0x1801, TPDO[1] + NODE, GuardState::MAPPING);
    assert_map(&mut node, 0x1802, TPDO[2] + NODE, GuardMargins::MAPPING);
    assert_map(&mut node, 0x1803, TPDO[3] + NODE, GuardPassed::MAPPING);
    assert_map(&mut node, 0x1804, TPDO[4] + NODE, GuardPosition::MAPPING);
}
