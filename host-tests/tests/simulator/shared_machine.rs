//! Tests that nodes on one emulated machine do not notice each other.

use tautrack::bus::cia402::mode::CYCLIC_POSITION;
use tautrack::bus::network::{NmtCommand, nmt};
use tautrack::bus::pdo::{Payload, PositionSetPoint, receive};
use tautrack::link::{STEP_US, Sensors, Start, Step, Stepped, VERSION};
use tautrack::settings::Setting;
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::robots::b2p2::nodes as b2p2;
use tautrack_host_tests::robots::{Kind, NodeName};
use tautrack_host_tests::simulator::run::Machines;
use tautrack_host_tests::simulator::run::node::Node;

/// A node in QEMU, and the same node as a process of the host.
struct Pair {
    id: u8,
    nodes: [Node; 2],
    steps: u64,
}

impl Pair {
    fn start(id: u8, machines: &mut Machines) -> Self {
        let name = NodeName::LEFT_TRACK;
        let mut start_on = |board| {
            let programs = Kind::B2p2.programs(board).expect("the nodes are built");
            let start = Start {
                version: VERSION,
                seed: u64::from(id),
                flash: heapless::String::new(),
                settings: [(Setting::NodeId.description().key, i32::from(id))]
                    .into_iter()
                    .collect(),
                motor: b2p2::motor(name),
            };
            let node = Node::start(name, board, &programs.axle.path, start, machines);
            node.unwrap_or_else(|error| panic!("{error}")).0
        };
        Self {
            id,
            nodes: [start_on(Board::Qemu), start_on(Board::Native)],
            steps: 0,
        }
    }

    /// Sends the next step: a drive that is switched on and turns, against another load and to
    /// another place than the others.
    fn send(&mut self) {
        self.steps += 1;
        let mut frames = heapless::Vec::new();
        let mut put = |frame| assert!(frames.push(frame).is_ok());
        if self.steps == 5 {
            put(nmt(NmtCommand::Start, 0));
        }
        if self.steps.is_multiple_of(4) {
            let set_point = PositionSetPoint {
                controlword: [0x06, 0x07, 0x0f][(self.steps / 20).min(2) as usize],
                mode: CYCLIC_POSITION,
                target: self.steps as i32 * i32::from(self.id),
            };
            put(set_point.frame(receive(1), self.id));
        }
        let step = Step {
            time_us: self.steps * STEP_US,
            sensors: Sensors {
                supply_voltage: 24.0,
                shaft_torque: f32::from(self.id) * 0.1,
                ..Sensors::default()
            },
            frames,
            serial: heapless::Vec::new(),
        };
        for node in &mut self.nodes {
            let sent = node.send(step.clone());
            sent.unwrap_or_else(|error| panic!("node {}: {error}", self.id));
        }
    }

    /// Compares the answers. The bytes of the log are those of another encoding on each board.
    fn receive(&mut self) -> Stepped {
        let [emulated, native] = self.nodes.each_mut().map(|node| {
            let stepped = node.receive();
            Stepped {
                log: heapless::Vec::new(),
                ..stepped.unwrap_or_else(|error| panic!("node {}: {error}", self.id))
            }
        });
        assert_eq!(emulated, native, "node {}, step {}", self.id, self.steps);
        emulated
    }
}

#[test]
fn nodes_that_share_a_machine_do_not_notice_each_other() {
    let mut machines = Machines::default();
    // More nodes than processors, so at least one machine has several.
    let processors = std::thread::available_parallelism().map_or(1, usize::from) as u8;
    let first = processors + 3;
    let mut pairs: Vec<Pair> = (1..=first)
        .map(|id| Pair::start(id, &mut machines))
        .collect();
    let mut velocities = std::collections::HashSet::new();
    for step in 0..400_usize {
        match step {
            // One node ends, and a new one starts, as after a restart.
            150 => drop(pairs.remove(1)),
            200 => pairs.insert(0, Pair::start(first + 1, &mut machines)),
            _ => {}
        }
        // The order differs from step to step, and each node misses one step in five.
        let count = pairs.len();
        pairs.rotate_left(step % count);
        let acts = |place: &usize| !(place + step).is_multiple_of(5);
        (0..count)
            .filter(acts)
            .for_each(|place| pairs[place].send());
        for place in (0..count).filter(acts) {
            velocities.insert(pairs[place].receive().shaft.velocity.to_bits());
        }
    }
    assert!(velocities.len() > 500, "the drives stand still");
}
