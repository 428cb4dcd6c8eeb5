//! Tests five nodes on one bus, without a robot: the guard starts the network, and the screw homes
//! and takes up the belt.

mod node;

use node::{MOTOR, Node, settings};
use tautrack::bus::network::{NmtState, as_emergency, as_heartbeat};
use tautrack::bus::pdo::{
    DriveMotion, GuardState, OperatorCommand, Payload, Request, receive, transmit,
};
use tautrack::can::Frame;
use tautrack::link::{BodyMeasurands, Sensors};
use tautrack::node::guard::State;
use tautrack::settings::Setting;

/// Roles and node ids that match the defaults of the settings.
const NODES: [(&str, i32); 5] = [
    ("guard", 1),
    ("axle", 2),
    ("axle", 3),
    ("axle", 4),
    ("screw", 5),
];
const GUARD: u8 = 1;
const SCREW: u8 = 5;

/// The nodes, and the frames that they sent in the previous step: index of the node and frame,
/// lowest identifier first.
struct Network {
    nodes: [Node; 5],
    sent: Vec<(usize, Frame)>,
    step: u32,
}

impl Network {
    fn new(start: impl Fn(&'static str) -> Node) -> Self {
        let nodes = NODES.map(|(role, id)| {
            let mut settings = settings(id);
            match id {
                4 => settings.push((Setting::PositionBits.description().key, 32)),
                // A screw with a large lead, so that this slow motor takes the belt up in some
                // seconds.
                5 => settings.push((Setting::ScrewLead.description().key, 50_000)),
                _ => {}
            }
            let mut node = start(role);
            let motor = (role != "guard").then_some(MOTOR);
            assert_eq!(node.start(&settings, motor), "");
            node
        });
        Self {
            nodes,
            sent: Vec::new(),
            step: 0,
        }
    }

    /// Runs one step. The operator requests to stop, and to arm from 1 s on.
    fn advance(&mut self) -> &[(usize, Frame)] {
        // m/s^2. Readings that never change are those of a stuck sensor.
        let noise = (self.step * 7 % 13) as f32 * 1e-3;
        let level = BodyMeasurands {
            tilt_force: [noise, 0.0, 9.81],
            specific_force: [noise, noise, 9.81 + noise],
            angular_rate: [noise; 3],
            ..Default::default()
        };
        let sensors = Sensors {
            supply_voltage: 24.0,
            body: Some(level),
            ..Default::default()
        };
        let mut sent = Vec::new();
        for (index, node) in self.nodes.iter_mut().enumerate() {
            let others = self.sent.iter().filter(|(from, _)| *from != index);
            let mut frames: Vec<_> = others.map(|(_, frame)| *frame).collect();
            if index == 0 && self.step > 500 && self.step.is_multiple_of(50) {
                let request = if self.step > 1_000 {
                    Request::Arm
                } else {
                    Request::Stop
                };
                let command = OperatorCommand {
                    request: request as u8,
                    sequence: (self.step / 50) as u8,
                    ..Default::default()
                };
                frames.push(command.frame(receive(1), GUARD));
            }
            let stepped = node.step(sensors, &frames);
            sent.extend(stepped.frames.iter().map(|frame| (index, *frame)));
        }
        sent.sort_by_key(|(_, frame)| frame.id());
        self.sent = sent;
        self.step += 1;
        &self.sent
    }
}

#[test]
fn guard_starts_the_network_and_arms_once_the_screw_is_in_place() {
    let mut network = Network::new(Node::host);
    let mut operational = [false; 6];
    let mut states = Vec::new();
    let mut extension = 0.0;
    for step in 0..16_000 {
        for (_, frame) in network.advance() {
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
        if states.last() == Some(&State::Armed.code()) {
            break;
        }
    }
    assert_eq!(operational, [false, true, true, true, true, true]);
    assert_eq!(
        states,
        [State::Ready, State::Starting(3), State::Armed].map(State::code)
    );
    // Tabulated extension of the robot's screw with the chassis straight, in m.
    assert!((extension - 0.226).abs() < 1e-3, "{extension}");
}

#[test]
fn emulated_network_sends_what_the_one_in_this_process_sends() {
    let (mut host, mut emulated) = (Network::new(Node::host), Network::new(Node::emulated));
    let begin = std::time::Instant::now();
    for step in 0..2_000 {
        assert_eq!(host.advance(), emulated.advance(), "step {step}");
    }
    let rate = 2_000.0 / begin.elapsed().as_secs_f64();
    println!("five emulated nodes beside five in this process: {rate:.0} steps a second");
}
