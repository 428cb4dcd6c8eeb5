//! Tests that a node's log has the same text on every board.

use tautrack::bus::cia402::mode::CYCLIC_POSITION;
use tautrack::bus::network::{NmtCommand, nmt};
use tautrack::bus::pdo::{Payload, PositionSetPoint, receive};
use tautrack::can::Frame;
use tautrack::link::{STEP_US, Sensors, Start, Step, VERSION};
use tautrack::settings::Setting;
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::robots::b2p2::nodes as b2p2;
use tautrack_host_tests::robots::{Kind, NodeName};
use tautrack_host_tests::simulator::run::node::Node;

const NODE: u8 = 4;

/// Frames to the node: the guard's heartbeat until 0.3 s, set-points all the time, and a client's
/// request for an object that does not exist.
fn frames(step: u64) -> heapless::Vec<Frame, 32> {
    let mut frames = heapless::Vec::new();
    let mut put = |frame| assert!(frames.push(frame).is_ok());
    if step == 5 {
        put(nmt(NmtCommand::Start, 0));
    }
    if (step == 2 || step.is_multiple_of(50)) && step < 300 {
        put(Frame::new(0x701, &[5]).expect("a heartbeat"));
    }
    if step == 100 {
        let request = [0x40, 0xff, 0x2f, 0, 0, 0, 0, 0];
        put(Frame::new(0x600 + u16::from(NODE), &request).expect("a request"));
    }
    if step.is_multiple_of(4) {
        let set_point = PositionSetPoint {
            controlword: [0x06, 0x07, 0x0f][(step / 40).min(2) as usize],
            mode: CYCLIC_POSITION,
            target: 0,
        };
        put(set_point.frame(receive(1), NODE));
    }
    frames
}

fn log(board: Board) -> Vec<String> {
    let programs = Kind::B2p2
        .programs(board)
        .unwrap_or_else(|error| panic!("{error}"));
    let name = NodeName::LEFT_TRACK;
    let key = Setting::NodeId.description().key;
    let start = Start {
        version: VERSION,
        seed: 1,
        flash: heapless::String::new(),
        settings: [(key, i32::from(NODE))].into_iter().collect(),
        motor: b2p2::motor(name),
        role: "axle".try_into().expect("a short name"),
    };
    let (mut node, _) = Node::start(name, board, &programs.nodes.path, start)
        .unwrap_or_else(|error| panic!("{error}"));
    let mut lines = Vec::new();
    for step in 1..=600 {
        let sent = node.send(Step {
            time_us: step * STEP_US,
            sensors: Sensors {
                supply_voltage: 24.0,
                ..Sensors::default()
            },
            frames: frames(step),
            serial: heapless::Vec::new(),
        });
        sent.unwrap_or_else(|error| panic!("{error}"));
        let stepped = node.receive().unwrap_or_else(|error| panic!("{error}"));
        lines.extend(node.log_lines(&stepped));
    }
    lines
}

#[test]
fn an_emulated_node_logs_the_lines_of_one_in_this_process() {
    let host = log(Board::Host);
    assert!(host.contains(&"WARN: fault 0x8130".to_owned()), "{host:?}");
    assert_eq!(log(Board::Qemu), host);
}
