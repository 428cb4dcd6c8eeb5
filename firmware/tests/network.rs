//! Five nodes on one bus, without a robot: the guard brings them up and the screw finds its place.

mod node;

use node::{MOTOR, Node, ROLES, settings};
use tautrack::bus::network::{NmtState, as_emergency, as_heartbeat};
use tautrack::bus::pdo::{
    DriveMotion, GuardState, OperatorCommand, Payload, Request, receive, transmit,
};
use tautrack::can::Frame;
use tautrack::link::{BodySensors, Sensors};
use tautrack::node::guard::State;
use tautrack::settings::Setting;

/// Roles and node ids, as the settings' defaults expect them.
const NODES: [(&str, i32); 5] = [
    ("guard", 1),
    ("axle", 2),
    ("axle", 3),
    ("axle", 4),
    ("screw", 5),
];
const GUARD: u8 = 1;
const SCREW: u8 = 5;

fn started(role: &str, id: i32) -> Node {
    let (_, program) = ROLES
        .into_iter()
        .find(|(name, _)| *name == role)
        .expect("a role");
    let mut settings = settings(id);
    match id {
        4 => settings.push((Setting::PositionBits.description().key, 32)),
        // A coarse screw, so that this slow motor takes the belt up in some seconds.
        5 => settings.push((Setting::ScrewLead.description().key, 50_000)),
        _ => {}
    }
    let mut node = Node::native(program);
    let motor = (role != "guard").then_some(MOTOR);
    assert_eq!(node.start(&settings, motor).refusal, "");
    node
}

#[test]
fn guard_starts_the_network_and_arms_once_the_screw_is_in_place() {
    let mut nodes = NODES.map(|(role, id)| started(role, id));
    let level = BodySensors {
        specific_force: [0.0, 0.0, 9.81],
        ..Default::default()
    };
    let sensors = Sensors {
        bus_voltage: 24.0,
        body: Some(level),
        ..Default::default()
    };
    let mut delivered: Vec<(usize, Frame)> = Vec::new();
    let mut operational = [false; 6];
    let mut states = Vec::new();
    let mut extension = 0.0;
    for step in 0..16_000_u32 {
        let mut sent = Vec::new();
        for (index, node) in nodes.iter_mut().enumerate() {
            let others = delivered.iter().filter(|(from, _)| *from != index);
            let mut frames: Vec<_> = others.map(|(_, frame)| *frame).collect();
            if index == 0 && step > 500 && step.is_multiple_of(50) {
                let (request, sequence) = (Request::Arm as u8, (step / 50) as u8);
                let command = OperatorCommand {
                    request,
                    sequence,
                    ..Default::default()
                };
                frames.push(command.frame(receive(1), GUARD));
            }
            sent.extend(
                node.step(sensors, &frames)
                    .frames
                    .iter()
                    .map(|frame| (index, *frame)),
            );
        }
        sent.sort_by_key(|(_, frame)| frame.id());
        for (_, frame) in &sent {
            assert_eq!(as_emergency(frame), None, "step {step}");
            if let Some((node, state)) = as_heartbeat(frame) {
                operational[usize::from(node)] = state == NmtState::Operational;
            }
            if let Some(motion) = DriveMotion::from_frame(frame, transmit(1), SCREW) {
                extension = f64::from(motion.position) / f64::from(1 << 24);
            }
            if let Some(state) = GuardState::from_frame(frame, transmit(2), GUARD)
                && states.last() != Some(&state.state)
            {
                states.push(state.state);
            }
        }
        delivered = sent;
        if states.last() == Some(&(State::Armed as u8)) {
            break;
        }
    }
    assert_eq!(operational, [false, true, true, true, true, true]);
    assert_eq!(
        states,
        [State::Ready, State::Tightening, State::Armed].map(|state| state as u8)
    );
    // The robot's tabulated extension with the chassis straight, in m.
    assert!((extension - 0.226).abs() < 1e-3, "{extension}");
}
