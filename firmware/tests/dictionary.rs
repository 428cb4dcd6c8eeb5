//! The PDO maps of the dictionaries are the codecs of `tautrack::bus::pdo`: what a node sends is what another reads.

mod node;

use node::{Node, ROLES, settings};
use tautrack::bus::network::function::{RPDO, TPDO};
use tautrack::bus::pdo::{
    DriveMotion, DriveStatus, GuardMargins, GuardMotion, GuardPassed, GuardState, OperatorCommand,
    PositionSetPoint, VelocitySetPoint,
};
use tautrack::can::Frame;
use tautrack::link::Sensors;

const NODE: u16 = 9;

/// An object of up to four bytes, read from the running node.
fn read(node: &mut Node, index: u16, sub: u8) -> u32 {
    let [low, high] = index.to_le_bytes();
    let request = Frame::new(0x600 + NODE, &[0x40, low, high, sub, 0, 0, 0, 0]).expect("a frame");
    let answers = node.step(Sensors::default(), &[request]).frames;
    let answer = answers
        .iter()
        .find(|frame| frame.id() == 0x580 + NODE)
        .expect("an answer");
    u32::from_le_bytes(answer.data()[4..].try_into().expect("eight bytes"))
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

fn started(role: &str) -> Node {
    let (_, program) = ROLES
        .into_iter()
        .find(|(name, _)| *name == role)
        .expect("a role");
    let mut node = Node::native(program);
    assert_eq!(node.start(&settings(i32::from(NODE)), None).refusal, "");
    node
}

#[test]
fn drives_map_what_the_codecs_say() {
    for role in ["axle", "screw"] {
        let mut node = started(role);
        assert_map(&mut node, 0x1400, RPDO[0] + NODE, PositionSetPoint::MAPPING);
        assert_map(&mut node, 0x1401, RPDO[1] + NODE, VelocitySetPoint::MAPPING);
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
}
