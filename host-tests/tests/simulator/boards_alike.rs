//! Tests that an emulated node behaves like one in this process: frames, log and flash.

use std::fs;
use std::path::PathBuf;
use tautrack::bus::cia402::mode::CYCLIC_POSITION;
use tautrack::bus::network::{NmtCommand, nmt};
use tautrack::bus::pdo::{Payload, PositionSetPoint, receive};
use tautrack::can::Frame;
use tautrack::link::{BodyMeasurands, STEP_US, Sensors, Start, Step, Stepped, VERSION};
use tautrack::settings::{FIRST_OBJECT, Setting};
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::robots::b2p2::nodes as b2p2;
use tautrack_host_tests::robots::{Kind, NodeName, Role};
use tautrack_host_tests::simulator::run::node::Node;

/// A node in QEMU, and the same node in this process.
struct Pair {
    id: u8,
    role: Role,
    nodes: [Node; 2],
    flash: [PathBuf; 2],
    logs: [Vec<String>; 2],
    steps: u64,
}

/// File for the flash of a node that does not exist yet.
fn blank(id: u8, board: Board) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("alike-{board:?}-{id}"));
    let _ = fs::remove_file(&path); // of an earlier run
    path
}

/// An SDO request to write four bytes.
fn write(id: u8, index: u16, sub: u8, data: [u8; 4]) -> Frame {
    request(id, 0x23, index, sub, data)
}

fn request(id: u8, command: u8, index: u16, sub: u8, data: [u8; 4]) -> Frame {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = data;
    let bytes = [command, low, high, sub, a, b, c, d];
    Frame::new(0x600 + u16::from(id), &bytes).expect("a frame")
}

impl Pair {
    fn start(id: u8) -> Self {
        let (name, role) = [
            (NodeName::GUARD, Role::Guard),
            (NodeName::LEFT_TRACK, Role::Axle),
            (NodeName::SCREW, Role::Screw),
        ][usize::from(id) % 3];
        let boards = [Board::Qemu, Board::Host];
        let flash = boards.map(|board| blank(id, board));
        // Every other node has no file for its flash.
        let named = |board: usize| {
            id.is_multiple_of(2)
                .then(|| flash[board].to_str())
                .flatten()
        };
        let start_on = |board: usize| {
            let (path, board) = (named(board).unwrap_or_default(), boards[board]);
            let programs = Kind::B2p2.programs(board).expect("the nodes are built");
            let start = Start {
                version: VERSION,
                seed: u64::from(id),
                flash: path.try_into().expect("a short path"),
                settings: [(Setting::NodeId.description().key, i32::from(id))]
                    .into_iter()
                    .collect(),
                motor: b2p2::motor(name),
                role: role.name().try_into().expect("a short name"),
            };
            let start = || {
                let path = &programs.nodes.path;
                let node = Node::start(name, board, path, start.clone());
                node.unwrap_or_else(|error| panic!("{error}")).0
            };
            // The second node finds the settings of the first one in flash, and logs that.
            if !path.is_empty() {
                start();
            }
            start()
        };
        Self {
            id,
            role,
            nodes: [start_on(0), start_on(1)],
            flash,
            logs: [Vec::new(), Vec::new()],
            steps: 0,
        }
    }

    /// The request of a client in this step: it changes and saves a setting twice before the drive
    /// is switched on, later records the current, and reads what was recorded. Each node gets its
    /// requests at another time than the others.
    fn client(&self) -> Option<Frame> {
        let id = self.id;
        let setting = FIRST_OBJECT + Setting::VelocityGain.description().key;
        let late = self.steps.checked_sub(u64::from(id) * 2)?;
        Some(match late {
            2 | 8 => {
                let value = 1_000 * i32::from(id) + late as i32;
                write(id, setting, 0, value.to_le_bytes())
            }
            5 | 11 => write(id, 0x1010, 1, *b"save"),
            70 => request(id, 0x2f, 0x2060, 1, [1, 0, 0, 0]),
            100 => request(id, 0x2b, 0x2062, 0, [id, 0, 0, 0]),
            110 => request(id, 0x40, 0x2063, 0, [0; 4]),
            // In segments of seven bytes.
            111..190 => request(id, [0x70, 0x60][late as usize % 2], 0, 0, [0; 4]),
            _ => return None,
        })
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
        self.client().into_iter().for_each(&mut put);
        let mut step = Step {
            time_us: self.steps * STEP_US,
            sensors: Sensors {
                supply_voltage: 24.0,
                shaft_torque: f32::from(self.id) * 0.1,
                ..Sensors::default()
            },
            frames,
            serial: heapless::Vec::new(),
        };
        if self.role == Role::Guard {
            let tilt = f32::from(self.id) * 0.1 + (self.steps % 50) as f32 * 0.01;
            step.sensors.body = Some(BodyMeasurands {
                tilt_force: [tilt, 0.0, 9.81],
                specific_force: [tilt, 0.0, 9.81],
                ..BodyMeasurands::default()
            });
            // A sentence of a receiver takes several steps.
            let sentence = format!("$GNGGA,{:06},{},", self.steps / 8, self.id);
            let place = (self.steps % 8) as usize * 2;
            step.serial.extend(sentence.bytes().skip(place).take(2));
        }
        for node in &mut self.nodes {
            let sent = node.send(step.clone());
            sent.unwrap_or_else(|error| panic!("node {}: {error}", self.id));
        }
    }

    /// Compares the answers. The bytes of the log are those of another encoding on each board.
    fn receive(&mut self) -> Stepped {
        let mut logs = self.logs.iter_mut();
        let [emulated, host] = self.nodes.each_mut().map(|node| {
            let stepped = node.receive();
            let stepped = stepped.unwrap_or_else(|error| panic!("node {}: {error}", self.id));
            logs.next().expect("two").extend(node.log_lines(&stepped));
            Stepped {
                log: heapless::Vec::new(),
                ..stepped
            }
        });
        assert_eq!(emulated, host, "node {}, step {}", self.id, self.steps);
        emulated
    }

    /// Compares the logs, and the files with the flash.
    fn compare_rest(&self) {
        let [emulated, host] = &self.logs;
        let speaks = self.role == Role::Guard || self.id.is_multiple_of(2);
        assert_eq!(!host.is_empty(), speaks, "node {}", self.id);
        assert_eq!(emulated, host, "node {}", self.id);
        let [emulated, host] = self.flash.each_ref().map(|path| fs::read(path).ok());
        assert_eq!(emulated.is_some(), self.id.is_multiple_of(2));
        assert_eq!(emulated, host, "node {}", self.id);
    }
}

#[test]
fn an_emulated_node_does_what_one_in_this_process_does() {
    let mut pairs: Vec<Pair> = (1..=6).map(Pair::start).collect();
    let mut velocities = std::collections::HashSet::new();
    let mut samples = std::collections::HashSet::new();
    for step in 0..400_usize {
        match step {
            // One node ends, and a new one starts, as after a restart.
            150 => drop(pairs.remove(1)),
            200 => pairs.insert(0, Pair::start(8)),
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
            let stepped = pairs[place].receive();
            velocities.insert(stepped.shaft.velocity.to_bits());
            let segments = stepped.frames.iter().filter(|frame| {
                frame.id() & 0x780 == 0x580 && frame.data().first().is_some_and(|byte| *byte < 0x20)
            });
            samples.extend(segments.map(|frame| frame.data()[1..].to_vec()));
        }
    }
    pairs.iter().for_each(Pair::compare_rest);
    assert!(samples.len() > 100, "{} segments", samples.len());
    assert!(velocities.len() > 500, "the drives stand still");
}
