//! A reset by the network management equals power-up, for every object of every role.

mod node;

use node::{MOTOR, Node, ROLES, settings};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use tautrack::can::Frame;
use tautrack::link::{BodyMeasurands, Sensors};

const NODE: u16 = 5;

/// Number of clients so far.
static CLIENTS: AtomicU32 = AtomicU32::new(0);

struct Client {
    node: Node,
    speed: f32,
    steps: u64,
    boots: usize,
}

impl Client {
    fn new(role: &'static str) -> Self {
        // The tests run at the same time.
        let number = CLIENTS.fetch_add(1, Ordering::Relaxed);
        let name = format!("reset-{number}.flash");
        let flash = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = std::fs::remove_file(&flash);
        let mut node = Node::host(role);
        let motor = (role != "guard").then_some(MOTOR);
        let flash = flash.to_str().expect("UTF-8");
        let settings = settings(NODE.into());
        // The second time it finds its settings in flash, as after a reset.
        for _ in 0..2 {
            assert_eq!(node.start_with_flash(flash, &settings, motor), "");
        }
        let mut client = Self {
            node,
            speed: 0.0,
            steps: 0,
            boots: 0,
        };
        client.run(100, &[]);
        assert_eq!(client.boots, 1);
        client
    }

    fn run(&mut self, steps: usize, frames: &[(u16, &[u8])]) -> Vec<Frame> {
        let frames: Vec<_> = frames
            .iter()
            .map(|(id, data)| Frame::new(*id, data).expect("a frame"))
            .collect();
        let mut sent = Vec::new();
        for step in 0..steps {
            self.steps += 1;
            let noise = (self.steps * 7 % 13) as f32 * 1e-3;
            let sensors = Sensors {
                supply_voltage: 24.0,
                body: Some(BodyMeasurands {
                    tilt_force: [noise, 0.0, 9.81],
                    specific_force: [noise, noise, 9.81 + noise],
                    angular_rate: [noise; 3],
                    ..BodyMeasurands::default()
                }),
                ..Sensors::default()
            };
            let stepped = self
                .node
                .step(sensors, if step == 0 { &frames } else { &[] });
            self.speed = stepped.shaft.velocity;
            sent.extend(stepped.frames);
        }
        let boot = Frame::new(0x700 + NODE, &[0]).expect("a frame");
        self.boots += sent.iter().filter(|frame| **frame == boot).count();
        sent
    }

    fn sdo(&mut self, request: [u8; 8]) -> [u8; 8] {
        let sent = self.run(2, &[(0x600 + NODE, &request)]);
        let answer = sent.iter().find(|frame| frame.id() == 0x580 + NODE);
        answer.expect("an answer").data().try_into().expect("eight")
    }

    /// Reads everything that takes at most four bytes.
    fn read(&mut self, objects: &[(u16, u8)]) -> BTreeMap<(u16, u8), [u8; 8]> {
        let read = |(index, sub): &(u16, u8)| {
            let [low, high] = index.to_le_bytes();
            let answer = self.sdo([0x40, low, high, *sub, 0, 0, 0, 0]);
            ((*index, *sub), answer)
        };
        objects.iter().map(read).collect()
    }
}

/// The objects of a role, without texts.
fn objects(role: &str) -> Vec<(u16, u8)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../docs/eds/{role}.eds"));
    let eds = std::fs::read_to_string(path).expect("the data sheet");
    let mut objects = Vec::new();
    for section in eds.split("\n[").skip(1) {
        let (name, rest) = section.split_once(']').expect("a section");
        let (index, sub) = name.split_once("sub").unwrap_or((name, "0"));
        let number = |text| u16::from_str_radix(text, 16).ok();
        let is_text = rest
            .lines()
            .any(|line| matches!(line, "DataType=0x0009" | "DataType=0x000A"));
        let is_value = rest.lines().any(|line| line.starts_with("DataType="));
        if let (Some(index), Some(sub), true) = (number(index), number(sub), is_value && !is_text) {
            objects.push((index, sub as u8));
        }
    }
    objects
}

/// What changes by itself: measured values, and the guard's view of the robot.
fn is_live(index: u16) -> bool {
    matches!(
        index,
        0x2003..=0x200f | 0x2040..=0x204f | 0x2100..=0x211f | 0x4000..=0x4fff | 0x6010..=0x6020
            | 0x6064 | 0x606c | 0x6077..=0x6079 | 0x607a
    )
}

#[test]
fn a_reset_by_the_network_management_equals_power_up() {
    for role in ROLES {
        let objects = objects(role);
        assert!(objects.len() > 100, "{role}: {}", objects.len());
        let mut client = Client::new(role);
        let before = client.read(&objects);
        // Writes everything that can be written, with other values.
        let mut changed = 0;
        for (index, sub) in &objects {
            // Saving and restoring are no values, and the last one ends bench mode by its command.
            if matches!(index, 0x1010 | 0x1011 | 0x1017 | 0x6040) {
                continue;
            }
            let [low, high] = index.to_le_bytes();
            let old = before[&(*index, *sub)];
            for add in [1_u8, 0xff, 5] {
                let mut request = old;
                request[0] = 0x23 | old[0] & 0x0c;
                request[4] = old[4].wrapping_add(add);
                assert_eq!(&request[1..4], &[low, high, *sub]);
                let answer = client.sdo(request);
                if answer[0] == 0x60 {
                    changed += 1;
                    break;
                }
            }
        }
        assert!(changed > 60, "{role}: {changed} objects were written");
        client.run(1, &[(0x000, &[129, NODE as u8])]);
        client.run(150, &[]);
        assert_eq!(client.boots, 2, "{role}");
        let after = client.read(&objects);
        for (place, value) in &before {
            let same = after[place] == *value || is_live(place.0);
            assert!(
                same,
                "{role} {place:x?}: {value:x?} before, {:x?} after",
                after[place]
            );
        }
    }
}

#[test]
fn a_drive_in_motion_comes_to_rest_before_it_restarts() {
    let other = NODE as u8 + 1;
    for (node, coasts, seen) in [
        (NODE as u8, false, true),
        (NODE as u8, true, true),
        (0, false, true),
        (other, false, false),
    ] {
        let mut client = Client::new("axle");
        client.run(1, &[(0x000, &[1, 0])]);
        client.sdo([0x2f, 0x01, 0x20, 0, 1, 0, 0, 0]);
        let command = |word: u8| {
            let [a, b, c, d] = 900_000_i32.to_le_bytes();
            [word, 0, 9, a, b, c, d]
        };
        for word in [6, 7, 15] {
            client.run(3, &[(0x300 + NODE, &command(word))]);
        }
        for _ in 0..100 {
            client.run(4, &[(0x300 + NODE, &command(15))]);
        }
        assert!(client.speed > 0.5, "{} rad/s", client.speed);
        let word = if coasts { 0 } else { 15 };
        let off = command(word);
        client.run(1, &[(0x000, &[129, node]), (0x300 + NODE, &off)]);
        // The client goes on commanding.
        let mut before = client.speed;
        for _ in 0..700 {
            let boots = client.boots;
            client.run(4, &[(0x300 + NODE, &off)]);
            if client.boots > boots {
                assert!(before.abs() < 0.1, "it restarts at {before} rad/s");
            }
            before = client.speed;
        }
        assert_eq!(client.boots, 1 + usize::from(seen), "reset of {node}");
        assert_eq!(client.speed > 0.5, !seen);
    }
}

#[test]
fn saved_settings_and_a_new_node_id_count_after_a_reset() {
    let mut client = Client::new("axle");
    // 2206 is the period of the heartbeat, 2201 the node id.
    let key = tautrack::settings::Setting::NodeId.description().key;
    let [low, high] = (tautrack::settings::FIRST_OBJECT + key).to_le_bytes();
    assert_eq!(client.sdo([0x23, low, high, 0, 9, 0, 0, 0])[0], 0x60);
    assert_eq!(
        client.sdo([0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e'])[0],
        0x60
    );
    let sent = client.run(1, &[(0x000, &[129, NODE as u8])]);
    assert!(sent.iter().all(|frame| frame.id() != 0x709));
    let sent = client.run(30, &[]);
    assert!(
        sent.contains(&Frame::new(0x709, &[0]).expect("a frame")),
        "{sent:?}"
    );
}

#[test]
fn a_guard_that_commands_nobody_restarts() {
    let mut client = Client::new("guard");
    client.run(1, &[(0x000, &[129, NODE as u8])]);
    client.run(30, &[]);
    assert_eq!(client.boots, 2);
}
