//! Tests the behaviour that a CANopen client can rely on. It uses nodes in this process;
//! `lockstep.rs` shows that emulated nodes behave the same.

mod node;

use node::{MOTOR, Node, ROLES, settings};
use tautrack::can::Frame;
use tautrack::link::Sensors;
use tautrack::settings::Setting;

const NODE: u16 = 5;
const GUARD: u16 = 1;
/// Drives of a guard with the id [`NODE`]: the screw has its default id no longer.
const DRIVES: [u16; 4] = [2, 3, 4, 6];

struct Client {
    node: Node,
    /// True position of the output shaft, 2^-32 turn, and its true speed, rad/s.
    truth: i64,
    speed: f32,
    /// Whether the guard's heartbeat is sent on the bus.
    guard: bool,
    /// NMT state in the guard's heartbeat: 0x7f while it waits for its drives, 5 from then on.
    guard_state: u8,
    steps: u32,
}

impl Client {
    fn new(role: &'static str) -> Self {
        let mut node = Node::host(role);
        let motor = (role != "guard").then_some(MOTOR);
        let mut settings = settings(i32::from(NODE));
        if role == "guard" {
            settings.push((Setting::ScrewId.description().key, i32::from(DRIVES[3])));
        }
        assert_eq!(node.start(&settings, motor), "");
        Self {
            node,
            truth: 0,
            speed: 0.0,
            guard: false,
            guard_state: 5,
            steps: 0,
        }
    }

    /// Like [`Client::new`], with a guard's heartbeat on the bus and the node operational.
    fn guarded(role: &'static str) -> Self {
        let mut client = Self::new(role);
        client.guard = true;
        client.send(&[(0x000, &[1, 0])]);
        client
    }

    /// A guard whose drives have answered. It has started the network and itself.
    fn ready_guard() -> Self {
        let mut client = Self::new("guard");
        client.answer_as_drives();
        assert_eq!(client.state_of_guard(), 5, "operational");
        client
    }

    /// Answers as the guard's drives do: with their heartbeats, states and position scales.
    fn answer_as_drives(&mut self) {
        for _ in 0..60 {
            for drive in DRIVES {
                self.send(&[
                    (0x700 + drive, &[5]),
                    (0x180 + drive, &[0; 8]),
                    // Switch on disabled.
                    (0x280 + drive, &[0x40, 0, 0, 0, 0, 0, 0, 0]),
                    (0x580 + drive, &[0x4b, 0x10, 0x20, 0, 16, 0, 0, 0]),
                ]);
            }
        }
    }

    /// NMT state in the next heartbeat of the node, which is a guard.
    fn state_of_guard(&mut self) -> u8 {
        *heartbeats(&self.idle(120)).last().expect("a heartbeat")
    }

    /// Sends `frames` in one step; returns the frames that the node sends in it.
    fn send(&mut self, frames: &[(u16, &[u8])]) -> Vec<Frame> {
        let guard = self.guard && self.steps.is_multiple_of(50);
        let state = [self.guard_state];
        let heartbeat = guard.then_some((0x700 + GUARD, state.as_slice()));
        self.steps += 1;
        let frames: Vec<_> = heartbeat
            .iter()
            .chain(frames)
            .map(|(id, data)| Frame::new(*id, data).expect("a frame"))
            .collect();
        let sensors = Sensors {
            supply_voltage: 24.0,
            ..Default::default()
        };
        let stepped = self.node.step(sensors, &frames);
        self.truth = stepped.shaft.position;
        self.speed = stepped.shaft.velocity;
        stepped.frames.to_vec()
    }

    /// Leads the drive to operation at position 0, with a controlword in each SYNC period.
    fn enable(&mut self) {
        for controlword in [6, 7, 15] {
            self.send(&[(0x200 + NODE, &set_point(controlword, 0))]);
            self.idle(3);
        }
    }

    fn idle(&mut self, steps: usize) -> Vec<Frame> {
        (0..steps).flat_map(|_| self.send(&[])).collect()
    }

    /// Sends an SDO request; returns the eight bytes of the answer.
    fn sdo(&mut self, request: [u8; 8]) -> [u8; 8] {
        let mut frames = self.send(&[(0x600 + NODE, &request)]);
        frames.extend(self.idle(5));
        let answer = frames
            .iter()
            .find(|frame| frame.id() == 0x580 + NODE)
            .expect("an answer within 5 ms");
        answer.data().try_into().expect("eight bytes")
    }

    /// Reads the value of an object of up to four bytes.
    fn read(&mut self, index: u16, sub: u8) -> u32 {
        let [low, high] = index.to_le_bytes();
        let answer = self.sdo([0x40, low, high, sub, 0, 0, 0, 0]);
        assert_eq!(
            answer[0] & 0xe3,
            0x43,
            "{index:#x}:{sub} answers {answer:x?}"
        );
        assert_eq!(&answer[1..4], &[low, high, sub]);
        u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]])
    }

    fn abort_code(answer: [u8; 8]) -> u32 {
        assert_eq!(answer[0], 0x80, "{answer:x?}");
        u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]])
    }
}

fn heartbeats(frames: &[Frame]) -> Vec<u8> {
    frames
        .iter()
        .filter(|frame| frame.id() == 0x700 + NODE)
        .map(|frame| frame.data()[0])
        .collect()
}

#[test]
fn node_boots_with_zero_then_beats_its_state() {
    let mut client = Client::new("axle");
    assert_eq!(heartbeats(&client.idle(350)), [0, 127, 127, 127]);
    client.send(&[(0x000, &[1, 5])]);
    assert_eq!(heartbeats(&client.idle(100)), [5]);
    client.send(&[(0x000, &[2, 0])]);
    assert_eq!(heartbeats(&client.idle(100)), [4]);
    assert_eq!(heartbeats(&client.send(&[(0x000, &[130, 5])])), [0]);
}

#[test]
fn heartbeat_obeys_a_write_to_its_period() {
    let mut client = Client::new("axle");
    assert_eq!(client.read(0x1017, 0), 100);
    assert_eq!(client.sdo([0x2b, 0x17, 0x10, 0, 20, 0, 0, 0])[0], 0x60);
    assert!((49..=51).contains(&heartbeats(&client.idle(1_000)).len()));
    client.sdo([0x2b, 0x17, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(heartbeats(&client.idle(1_000)).len(), 0);
    // A reset of communication restores it.
    client.send(&[(0x000, &[130, NODE as u8])]);
    assert_eq!(client.read(0x1017, 0), 100);
    assert!((9..=11).contains(&heartbeats(&client.idle(1_000)).len()));
}

#[test]
fn device_types_name_their_profiles() {
    assert_eq!(Client::new("axle").read(0x1000, 0), 0x0002_0192);
    assert_eq!(Client::new("screw").read(0x1000, 0), 0x0002_0192);
    assert_eq!(Client::new("guard").read(0x1000, 0) & 0xffff, 410);
}

#[test]
fn drives_send_their_state_on_every_sync_and_the_rest_on_every_fifth() {
    for role in ["axle", "screw"] {
        let mut client = Client::new(role);
        assert!(
            client
                .send(&[(0x080, &[])])
                .iter()
                .all(|frame| frame.id() > 0x700),
            "no PDO before NMT start"
        );
        client.send(&[(0x000, &[1, 0])]);
        let mut counts = [0; 2];
        for _ in 0..50 {
            for frame in client.send(&[(0x080, &[])]) {
                match frame.id() - NODE {
                    0x180 => counts[0] += 1,
                    0x280 => counts[1] += 1,
                    _ => continue,
                }
                assert_eq!(frame.data().len(), 8);
            }
        }
        assert_eq!(counts, [50, 10], "{role}");
    }
}

#[test]
fn set_points_reach_their_objects() {
    let mut client = Client::new("axle");
    client.send(&[(0x000, &[1, 0])]);
    client.send(&[(0x200 + NODE, &[0x06, 0, 8, 0x44, 0x33, 0x22, 0x11])]);
    assert_eq!(client.read(0x607a, 0), 0x1122_3344);
    assert_eq!(client.read(0x6060, 0), 8);
    client.send(&[(0x300 + NODE, &[0x06, 0, 9, 0xff, 0xff, 0xff, 0xff])]);
    assert_eq!(client.read(0x60ff, 0), 0xffff_ffff);
}

#[test]
fn screw_receives_its_joint_directly_even_after_a_reset_of_communication() {
    let mut client = Client::new("screw");
    let joint = Setting::JointId.description().default as u16;
    for position in [0x1122_3344_u32, 0x0102_0304] {
        client.send(&[(0x000, &[1, 0])]);
        let mut motion = [0xff; 8];
        motion[..4].copy_from_slice(&position.to_le_bytes());
        client.send(&[(0x180 + joint, &motion)]);
        assert_eq!(client.read(0x2100, 1), position);
        assert_eq!(client.read(0x2100, 2), 0xffff_ffff);
        client.send(&[(0x000, &[130, 0])]);
    }
}

#[test]
fn guard_makes_the_sync_and_sends_its_own_process_data_on_it() {
    let mut client = Client::ready_guard();
    let frames = client.idle(400);
    let count = |id| frames.iter().filter(|frame| frame.id() == id).count();
    assert_eq!(count(0x080), 100, "SYNC every 4 ms");
    for function in [0x180, 0x280, 0x380, 0x480] {
        assert_eq!(
            count(function + NODE),
            20,
            "{function:#x} on every fifth SYNC"
        );
    }
}

#[test]
fn operator_command_reaches_the_guard_as_process_data() {
    let mut client = Client::ready_guard();
    let [low, high] = 250_i16.to_le_bytes();
    client.send(&[(0x200 + NODE, &[low, high, 0, 0, 0, 0, 0, 1])]);
    client.idle(40);
    assert_eq!(client.read(0x4004, 1), 250, "asked speed");
}

/// Position set-point with the given controlword; `target` in 2^-16 turn of the output shaft.
fn set_point(controlword: u8, target: i32) -> [u8; 7] {
    let [a, b, c, d] = target.to_le_bytes();
    [controlword, 0, 8, a, b, c, d]
}

#[test]
fn axle_follows_its_set_points_and_stops_when_they_end() {
    let mut client = Client::guarded("axle");
    client.enable();
    // Turns a quarter turn in half a second.
    for step in 0..=500 {
        let frames: &[(u16, &[u8])] = &[
            (0x080, &[]),
            (0x200 + NODE, &set_point(15, step * 0x4000 / 500)),
        ];
        client.send(if step % 4 == 0 { frames } else { &[] });
    }
    for _ in 0..40 {
        client.send(&[(0x200 + NODE, &set_point(15, 0x4000))]);
        client.idle(3);
    }
    let position = client.read(0x6064, 0) as i32;
    assert!(
        (i64::from(position) - (client.truth >> 16)).abs() < 0x10,
        "{position:#x} {:#x}",
        client.truth
    );
    assert!((position - 0x4000).abs() < 0x40, "{position:#x}");
    assert_eq!(client.read(0x6041, 0) & 0x6f, 0x27, "operation enabled");

    let silence = client.idle(100);
    let emergency = silence
        .iter()
        .find(|frame| frame.id() == 0x080 + NODE)
        .expect("an emergency frame");
    assert_eq!(emergency.data()[..3], [0x50, 0x82, 0x11], "command lost");
    assert_eq!(client.read(0x603f, 0), 0x8250);
    assert_eq!(client.read(0x1001, 0), 0x11);
    assert_eq!(client.read(0x6041, 0) & 0x6f, 0x07, "quick stop active");
}

#[test]
fn writing_what_is_no_set_point_does_not_stand_for_one() {
    let mut client = Client::guarded("axle");
    client.enable();
    let mut received = Vec::new();
    for _ in 0..100 {
        received.extend(client.send(&[(0x600 + NODE, &[0x2b, 0x17, 0x10, 0, 100, 0, 0, 0])]));
    }
    assert!(
        received.iter().any(|frame| frame.id() == 0x080 + NODE),
        "the heartbeat's period kept the axle alive"
    );
}

#[test]
fn a_guard_that_waits_for_its_drives_enables_none_of_them() {
    for role in ["axle", "screw"] {
        let mut client = Client::guarded(role);
        let drive = |client: &mut Client| {
            let mut fastest = 0.0_f32;
            for step in 0..300 {
                let word = [6, 7, 15][(step / 10).min(2)];
                client.send(&[(0x300 + NODE, &velocity(word, 3.0))]);
                client.idle(3);
                fastest = fastest.max(client.speed.abs());
            }
            fastest
        };
        client.guard_state = 0x7f;
        client.idle(100);
        client.send(&[(0x000, &[1, 0])]);
        assert_eq!(drive(&mut client), 0.0, "{role}");
        assert_ne!(client.read(0x6041, 0) & 0x6f, 0x27, "{role} is enabled");
        // The same frames move it once the guard is ready.
        client.guard_state = 5;
        client.idle(100);
        assert!(drive(&mut client) > 1.0, "{role}");
    }
}

/// CiA 301: a master takes no network management command of another node. One that commands nobody
/// may be reset alone.
#[test]
fn a_guard_follows_no_network_command_of_another_node() {
    let mut client = Client::new("guard");
    client.idle(300);
    for node in [0, NODE as u8] {
        for command in [1, 2, 128, 129, 130] {
            if (command, node) == (129, NODE as u8) {
                continue;
            }
            let mut sent = client.send(&[(0x000, &[command, node])]);
            sent.extend(client.idle(120));
            let states = heartbeats(&sent);
            assert!(states.iter().all(|state| *state == 127), "{states:?}");
            assert!(!states.is_empty());
        }
    }
    let master = client.read(0x4001, 5);
    assert_eq!(master, 0xff03, "it reports a second master");
    client.answer_as_drives();
    assert_eq!(client.state_of_guard(), 5, "its own command starts it");
    for command in [2, 128, 129, 130, 1] {
        client.send(&[(0x000, &[command, 0])]);
        assert_eq!(client.state_of_guard(), 5, "{command}");
    }
}

/// Identifiers, transmission types and mapped objects of the process data of a drive, and the
/// period of its heartbeat.
fn communication(client: &mut Client) -> Vec<(u16, u8, u32)> {
    let mut objects = vec![(0x1017, 0, client.read(0x1017, 0))];
    for number in 0..4 {
        for index in [0x1400 + number, 0x1800 + number] {
            objects.extend([1, 2].map(|sub| (index, sub, client.read(index, sub))));
        }
        for index in [0x1600 + number, 0x1a00 + number] {
            let count = client.read(index, 0) as u8;
            objects.extend((0..=count).map(|sub| (index, sub, client.read(index, sub))));
        }
    }
    objects
}

#[test]
fn what_a_client_wrote_to_communication_objects_ends_when_the_guard_is_ready() {
    for role in ["axle", "screw"] {
        let mut client = Client::new(role);
        client.idle(10);
        let started = communication(&mut client);
        // The guard is absent in the first round, and waits for its drives in the second one. It is
        // lost after the first round.
        for waits in [false, true] {
            client.guard = waits;
            client.guard_state = 0x7f;
            client.idle(400);
            let refused = forge(&mut client);
            assert_eq!(refused > 0, waits, "{role}: {refused} writes are refused");
            assert_ne!(communication(&mut client), started, "{role}");
            client.guard = true;
            client.guard_state = 5;
            client.idle(100);
            assert_eq!(communication(&mut client), started, "{role}: {waits}");
        }
    }
}

/// Writes other identifiers, transmission types and mappings to all process data, and another
/// period of the heartbeat. Returns how many writes the node refuses.
fn forge(client: &mut Client) -> usize {
    let mut refused = 0;
    let mut write = |index: u16, sub: u8, value: &[u8]| {
        let [low, high] = index.to_le_bytes();
        let mut request = [0; 8];
        request[..4].copy_from_slice(&[0x23 | (4 - value.len() as u8) << 2, low, high, sub]);
        request[4..4 + value.len()].copy_from_slice(value);
        refused += usize::from(client.sdo(request)[0] == 0x80);
    };
    for number in 0..4_u8 {
        for (parameter, mapping, object, bits) in [
            (0x1400, 0x1600, [0x20, 0, 0xff, 0x60], 0), // target velocity
            (0x1800, 0x1a00, [0x20, 0, 0x6c, 0x60], 0x40), // velocity
        ] {
            let identifier = |not_used: u8| [0x70 + number, 3, 0, bits | not_used];
            write(parameter + u16::from(number), 1, &identifier(0x80));
            write(parameter + u16::from(number), 2, &[7]);
            write(mapping + u16::from(number), 0, &[0]);
            write(mapping + u16::from(number), 1, &object);
            write(mapping + u16::from(number), 0, &[1]);
            write(parameter + u16::from(number), 1, &identifier(0));
        }
    }
    write(0x1017, 0, &[33, 0]);
    refused
}

const DEVICE_STATE: u32 = 0x0800_0022;

#[test]
fn no_client_writes_what_moves_an_axle_while_the_guard_is_alive() {
    let mut client = Client::guarded("axle");
    // Writes to controlword, mode, targets, torque feed-forward, bench mode, and the identifier of
    // a receive PDO.
    let writes: [[u8; 8]; 7] = [
        [0x2b, 0x40, 0x60, 0, 6, 0, 0, 0],
        [0x2f, 0x60, 0x60, 0, 9, 0, 0, 0],
        [0x23, 0x7a, 0x60, 0, 1, 0, 0, 0],
        [0x23, 0xff, 0x60, 0, 1, 0, 0, 0],
        [0x2b, 0xb2, 0x60, 0, 1, 0, 0, 0],
        [0x2f, 0x01, 0x20, 0, 1, 0, 0, 0],
        [0x23, 0x00, 0x14, 1, 0x05, 0x03, 0, 0],
    ];
    for write in writes {
        assert_eq!(Client::abort_code(client.sdo(write)), DEVICE_STATE);
    }
    assert_eq!(client.read(0x60ff, 0), 0);
    // Without a guard, the same writes are accepted.
    client.guard = false;
    client.idle(130);
    for write in &writes[..6] {
        assert_eq!(client.sdo(*write)[0], 0x60, "{write:x?}");
    }
}

/// The write in segments begins before the guard's first heartbeat.
#[test]
fn a_write_that_began_before_the_guard_does_not_end_while_it_is_alive() {
    let mut client = Client::guarded("axle");
    client.guard = false;
    client.idle(130);
    assert_eq!(client.sdo([0x21, 0xff, 0x60, 0, 4, 0, 0, 0])[0], 0x60);
    client.guard = true;
    client.idle(130);
    let end = client.sdo([0x07, 0x20, 0xa1, 0x07, 0, 0, 0, 0]);
    assert_eq!(Client::abort_code(end), DEVICE_STATE);
    assert_eq!(client.read(0x60ff, 0), 0);
}

/// Velocity set-point with the given controlword; `speed` in rad/s.
fn velocity(controlword: u8, speed: f32) -> [u8; 7] {
    let [a, b, c, d] = ((speed * 1e6) as i32).to_le_bytes();
    [controlword, 0, 9, a, b, c, d]
}

#[test]
fn a_client_drives_an_axle_in_bench_mode_alone_and_slowly() {
    let mut client = Client::new("axle");
    client.send(&[(0x000, &[1, 0])]);
    let drive = |client: &mut Client, bench: bool| {
        if bench {
            assert_eq!(client.sdo([0x2f, 0x01, 0x20, 0, 1, 0, 0, 0])[0], 0x60);
        }
        for controlword in [6, 7, 15] {
            client.send(&[(0x200 + NODE + 0x100, &velocity(controlword, 3.0))]);
        }
        let mut fastest = 0.0_f32;
        for _ in 0..500 {
            client.send(&[(0x300 + NODE, &velocity(15, 3.0))]);
            fastest = fastest.max(client.speed.abs());
        }
        fastest
    };
    assert_eq!(drive(&mut client, false), 0.0, "without bench mode");
    let fastest = drive(&mut client, true);
    assert!((0.9..1.2).contains(&fastest), "{fastest} rad/s");
    assert_eq!(client.read(0x2001, 0), 1);

    // The guard's heartbeat ends bench mode, even if the client goes on sending.
    client.guard = true;
    for _ in 0..400 {
        client.send(&[(0x300 + NODE, &velocity(15, 3.0))]);
    }
    assert!(client.speed.abs() < 0.02, "{} rad/s", client.speed);
    assert_eq!(client.read(0x2001, 0), 0);
    assert_eq!(client.read(0x6041, 0) & 0x6f, 0x07, "quick stop active");
}

#[test]
fn a_node_whose_tasks_stop_is_reset_by_its_watchdog() {
    for role in ROLES {
        let mut node = Node::emulated(role);
        let motor = (role != "guard").then_some(MOTOR);
        assert_eq!(node.start(&settings(i32::from(NODE)), motor), "");
        node.step(Sensors::default(), &[]);
        // No task of the node runs for longer than the watchdog's 50 ms.
        let (well, said) = node.starve(60_000);
        assert!(!well, "{role} ends with an error");
        assert!(said.contains("watchdog: not fed"), "{role}: {said}");
    }
}

#[test]
fn objects_that_do_not_exist_or_cannot_be_written_say_so() {
    let mut client = Client::new("axle");
    assert_eq!(
        Client::abort_code(client.sdo([0x40, 0x0a, 0x20, 1, 0, 0, 0, 0])),
        0x0602_0000
    );
    assert_eq!(
        Client::abort_code(client.sdo([0x40, 0x18, 0x10, 9, 0, 0, 0, 0])),
        0x0609_0011
    );
    assert_eq!(
        Client::abort_code(client.sdo([0x2b, 0x41, 0x60, 0, 1, 0, 0, 0])),
        0x0601_0002
    );
}

#[test]
fn known_ways_to_panic_the_stack_are_answered_by_aborts() {
    let mut client = Client::new("axle");
    // An empty segment for the count of a mapping.
    let (_, mapping) = (
        client.sdo([0x23, 0x02, 0x18, 1, 0x85, 0x03, 0, 0xc0]),
        [0x20, 0x02, 0x1a, 0, 0, 0, 0, 0],
    );
    assert_eq!(client.sdo(mapping)[0], 0x60);
    let end = client.sdo([0x0f, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(Client::abort_code(end), 0x0607_0013);
    // The client's abort in the middle of a block upload.
    client.sdo([0xa0, 0x08, 0x10, 0, 1, 0, 0, 0]);
    client.send(&[(0x600 + NODE, &[0xa3, 0, 0, 0, 0, 0, 0, 0])]);
    client.send(&[(0x600 + NODE, &[0x80, 0x08, 0x10, 0, 0, 0, 0, 0])]);
    client.idle(30);
    assert_eq!(client.read(0x1000, 0), 0x0002_0192);
    // The transmission type of a PDO, mapped with no bits.
    let answer = client.sdo([0x23, 0x02, 0x1a, 1, 0x00, 0x02, 0x00, 0x18]);
    assert_eq!(Client::abort_code(answer), 0x0602_0000);
    // A PDO without objects is not sent.
    for request in [
        [0x2f, 0x02, 0x18, 2, 1, 0, 0, 0],
        [0x23, 0x02, 0x18, 1, 0x85, 0x03, 0, 0x40],
    ] {
        assert_eq!(client.sdo(request)[0], 0x60);
    }
    client.send(&[(0x000, &[1, 0])]);
    let sent = client.send(&[(0x080, &[])]);
    assert!(sent.iter().all(|frame| frame.id() != 0x385));
}

#[test]
fn an_object_is_written_and_read_in_segments() {
    let mut client = Client::new("axle");
    assert_eq!(upload(&mut client, 0x1008), b"tautrack axle");
    // The target velocity, with its size given or not, in one segment or two.
    let first = |with_size: u8| [0x20 | with_size, 0xff, 0x60, 0, 4 * with_size, 0, 0, 0];
    assert_eq!(client.sdo(first(1)), [0x60, 0xff, 0x60, 0, 0, 0, 0, 0]);
    assert_eq!(client.sdo([0x07, 1, 2, 3, 4, 0, 0, 0])[0], 0x20);
    assert_eq!(client.read(0x60ff, 0), 0x0403_0201);
    assert_eq!(client.sdo(first(0))[0], 0x60);
    assert_eq!(client.sdo([0x08, 5, 6, 7, 0, 0, 0, 0])[0], 0x20);
    assert_eq!(client.sdo([0x1d, 8, 0, 0, 0, 0, 0, 0])[0], 0x30);
    assert_eq!(client.read(0x60ff, 0), 0x0807_0605);
    // Too short, too long for a number, and too long for the server.
    for (last, code) in [(0x09, 0x0607_0013), (0x05, 0x0607_0012)] {
        client.sdo(first(0));
        let answer = client.sdo([last, 9, 9, 9, 9, 9, 9, 9]);
        assert_eq!(Client::abort_code(answer), code);
    }
    client.sdo(first(0));
    client.sdo([0x00, 9, 9, 9, 9, 9, 9, 9]);
    let answer = client.sdo([0x11, 9, 9, 9, 9, 9, 9, 9]);
    assert_eq!(Client::abort_code(answer), 0x0607_0012);
    // The size that is announced, and an object that cannot be written.
    let answer = client.sdo([0x21, 0xff, 0x60, 0, 2, 0, 0, 0]);
    assert_eq!(Client::abort_code(answer), 0x0607_0013);
    let answer = client.sdo([0x21, 0x41, 0x60, 0, 2, 0, 0, 0]);
    assert_eq!(Client::abort_code(answer), 0x0601_0002);
    assert_eq!(client.read(0x60ff, 0), 0x0807_0605);
}

#[test]
fn a_transfer_ends_with_a_wrong_segment_an_abort_or_a_pause() {
    let mut client = Client::new("axle");
    let text = [0x40, 0x08, 0x10, 0, 0, 0, 0, 0];
    client.sdo(text);
    let answer = client.sdo([0x70, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(answer[..4], [0x80, 0x08, 0x10, 0]);
    assert_eq!(Client::abort_code(answer), 0x0503_0000);
    // A segment without a transfer.
    let answer = client.sdo([0x60, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(Client::abort_code(answer), 0x0504_0001);
    // An abort has no answer, within a transfer and without one.
    client.sdo(text);
    for _ in 0..2 {
        let mut sent = client.send(&[(0x600 + NODE, &[0x80, 0x08, 0x10, 0, 0, 0, 0, 0])]);
        sent.extend(client.idle(50));
        assert!(sent.iter().all(|frame| frame.id() != 0x580 + NODE));
    }
    client.sdo(text);
    let answered = client.idle(490);
    assert!(answered.iter().all(|frame| frame.id() != 0x580 + NODE));
    let ended = client.idle(20);
    let ended = ended.iter().find(|frame| frame.id() == 0x580 + NODE);
    let ended = ended.expect("the end of the transfer").data();
    assert_eq!(ended, [0x80, 0x08, 0x10, 0, 0, 0, 4, 5]);
    assert_eq!(upload(&mut client, 0x1008), b"tautrack axle");
}

#[test]
fn process_data_before_the_start_of_a_node_are_ignored() {
    let mut client = Client::new("axle");
    client.send(&[(0x300 + NODE, &velocity(0x06, 0.1))]);
    client.send(&[(0x000, &[1, 0])]);
    client.idle(5);
    assert_eq!((client.read(0x6040, 0), client.read(0x60ff, 0)), (0, 0));
}

#[test]
fn process_data_that_are_too_short_are_ignored() {
    let mut client = Client::guarded("axle");
    client.enable();
    // No part of them is written, and they are no set-point that keeps the axle in operation.
    let mut received = Vec::new();
    for _ in 0..100 {
        for length in [0, 2, 6] {
            let short = &set_point(6, 1)[..length];
            received.extend(client.send(&[(0x200 + NODE, short)]));
        }
    }
    let lost = received.iter().any(|frame| frame.id() == 0x080 + NODE);
    assert!(lost, "short process data kept the axle alive");
    assert_eq!(client.read(0x6040, 0), 15);
    // More bytes than the PDO carries are ignored.
    client.send(&[(0x200 + NODE, &[0x06, 0, 8, 1, 0, 0, 0, 0xff])]);
    assert_eq!((client.read(0x6040, 0), client.read(0x607a, 0)), (6, 1));
}

#[test]
fn a_stopped_node_answers_no_request() {
    let mut client = Client::new("axle");
    client.sdo([0x40, 0x08, 0x10, 0, 0, 0, 0, 0]);
    client.send(&[(0x000, &[2, NODE as u8])]);
    // A segment, objects of the dictionary and of the settings, and a block transfer.
    for request in [
        [0x60, 0, 0, 0, 0, 0, 0, 0],
        [0x40, 0x00, 0x10, 0, 0, 0, 0, 0],
        [0x2b, 0x17, 0x10, 0, 10, 0, 0, 0],
        [0x40, 0x10, 0x10, 1, 0, 0, 0, 0],
        [0xa0, 0x08, 0x10, 0, 20, 0, 0, 0],
    ] {
        let mut sent = client.send(&[(0x600 + NODE, &request)]);
        sent.extend(client.idle(40));
        let answered = sent.iter().any(|frame| frame.id() == 0x580 + NODE);
        assert!(!answered, "{request:x?}");
    }
    client.send(&[(0x000, &[128, NODE as u8])]);
    assert_eq!(client.read(0x1017, 0), 100);
}

#[test]
fn a_reset_ends_a_transfer() {
    for command in [129, 130] {
        let mut client = Client::new("axle");
        client.sdo([0x40, 0x08, 0x10, 0, 0, 0, 0, 0]);
        let mut sent = client.send(&[(0x000, &[command, NODE as u8])]);
        sent.extend(client.idle(40));
        assert_eq!(heartbeats(&sent)[0], 0);
        assert!(sent.iter().all(|frame| frame.id() != 0x580 + NODE));
    }
}

#[test]
fn a_new_request_replaces_a_transfer() {
    let mut client = Client::new("axle");
    client.sdo([0x40, 0x08, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(client.read(0x1000, 0), 0x0002_0192);
    // A write in segments, of which none comes.
    client.sdo([0x20, 0xff, 0x60, 0, 0, 0, 0, 0]);
    assert_eq!(upload(&mut client, 0x1008), b"tautrack axle");
    // The aborted request names its own object.
    client.sdo([0x40, 0x08, 0x10, 0, 0, 0, 0, 0]);
    let answer = client.sdo([0x40, 0x0a, 0x20, 1, 0, 0, 0, 0]);
    assert_eq!(answer[..4], [0x80, 0x0a, 0x20, 1]);
    assert_eq!(Client::abort_code(answer), 0x0602_0000);
}

#[test]
fn a_write_without_a_size_has_the_size_of_its_object() {
    let mut client = Client::new("axle");
    for (index, value) in [(0x1017_u16, 50_u32), (0x2001, 0), (0x60ff, 0x0102_0304)] {
        let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), value.to_le_bytes());
        let answer = client.sdo([0x22, low, high, 0, a, b, c, d]);
        assert_eq!(answer, [0x60, low, high, 0, 0, 0, 0, 0]);
        assert_eq!(client.read(index, 0), value);
    }
    let answer = client.sdo([0x22, 0x41, 0x60, 0, 1, 0, 0, 0]);
    assert_eq!(Client::abort_code(answer), 0x0601_0002);
}

#[test]
fn every_request_has_one_answer_that_names_its_object() {
    let mut client = Client::new("axle");
    let indices = [
        0x1000_u16, 0x1008, 0x1017, 0x1018, 0x1400, 0x1a00, 0x2063, 0x2200, 0x6041, 0x60ff, 0x6502,
    ];
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut in_block = false;
    for _ in 0..4_000 {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        let mut request = state.to_le_bytes();
        let index = indices[(state >> 40) as usize % indices.len()];
        request[1..3].copy_from_slice(&index.to_le_bytes());
        request[3] %= 4;
        let mut sent = client.send(&[(0x600 + NODE, &request)]);
        sent.extend(client.idle(2));
        let answers: Vec<_> = sent
            .iter()
            .filter(|frame| frame.id() == 0x580 + NODE)
            .collect();
        // A segment of a block is anything but an abort. The client ends it with one.
        if in_block {
            client.send(&[(0x600 + NODE, &[0x80, 0, 0, 0, 0, 0, 0, 0])]);
            in_block = false;
            continue;
        }
        // An abort has no answer, and the start of a block the segments.
        let specifier = request[0] >> 5;
        if specifier == 4 || specifier == 5 && request[0] & 3 != 0 {
            continue;
        }
        assert_eq!(answers.len(), 1, "{request:x?}");
        in_block = answers[0].data()[0] >> 5 == 5;
        // A segment names no object, nor does the end of a block.
        let block = specifier == 6 && request[0] & 1 == 0 || specifier == 5;
        if matches!(specifier, 1 | 2 | 7) || block {
            assert_eq!(answers[0].data()[1..4], request[1..4], "{request:x?}");
        }
    }
    assert_eq!(client.read(0x1000, 0), 0x0002_0192);
    assert_eq!(client.read(0x6502, 0), 933);
    assert_eq!(upload(&mut client, 0x1008), b"tautrack axle");
}

#[test]
fn no_frame_panics_a_node() {
    for role in ROLES {
        let mut client = Client::new(role);
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        let mut random = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state
        };
        for _ in 0..20_000 {
            let frames: Vec<_> = (0..8)
                .map(|_| {
                    let id = match random() % 16 {
                        0 => random() as u16 & 0x7ff,
                        1 => 0x000,
                        2 => 0x080,
                        3 => 0x200 + NODE,
                        4 => 0x7e5,
                        _ => 0x600 + NODE,
                    };
                    let mut data = random().to_le_bytes();
                    if id == 0x000 {
                        data[0] = [1, 2, 128, 128, 129, 130][random() as usize % 6];
                        data[1] = [0, NODE as u8][random() as usize % 2];
                    }
                    // Three of four requests use commands that the stack handles badly, or address
                    // objects that exist.
                    if id == 0x600 + NODE && random() % 4 != 0 {
                        let index =
                            [0x1600, 0x1a00, 0x1400, 0x1017, 0x1008, 0x6040][random() as usize % 6];
                        data[0] =
                            [0x40, 0x20, 0x21, 0x2f, 0x23, 0x60, 0x0f, 0x0f][random() as usize % 8];
                        data[1..3].copy_from_slice(&u16::to_le_bytes(index));
                        data[3] %= 3;
                    }
                    let length = if random() % 4 == 0 {
                        random() as usize % 9
                    } else {
                        8
                    };
                    Frame::new(id, &data[..length]).expect("a frame")
                })
                .collect();
            let sensors = Sensors {
                supply_voltage: 24.0,
                ..Default::default()
            };
            client.node.step(sensors, &frames); // panics if the node has panicked
        }
        assert!(client.node.finish(), "{role}");
    }
}

#[test]
fn a_client_writes_the_parameters_of_a_drive_and_no_unsupported_value() {
    for role in ["axle", "screw"] {
        let mut client = Client::new(role);
        client.idle(5);
        let started = [
            (0x605a, 6),
            (0x605b, 0),
            (0x605d, 1),
            (0x605e, 2),
            (0x6066, 100),
            (0x6068, 20),
            (0x6502, 933),
        ];
        for (index, value) in started {
            assert_eq!(client.read(index, 0), value, "{index:#x} of a {role}");
        }
        assert_ne!(client.read(0x6065, 0), 0, "following_limit");
        let written = client.sdo([0x2b, 0x5a, 0x60, 0, 5, 0, 0, 0]);
        assert_eq!(written[0], 0x60);
        assert_eq!(client.read(0x605a, 0), 5);
        let refused = [
            [0x2b, 0x5a, 0x60, 0, 3, 0, 0, 0],
            [0x2f, 0x98, 0x60, 0, 35, 0, 0, 0],
            [0x2f, 0x60, 0x60, 0, 4, 0, 0, 0],
        ];
        for request in refused {
            let answer = client.sdo(request);
            assert_eq!(Client::abort_code(answer), 0x0609_0030, "{request:x?}");
        }
        assert_eq!(client.read(0x605a, 0), 5);
    }
}

#[test]
fn a_client_stops_an_axle_with_the_option_code_that_it_wrote() {
    let mut client = Client::new("axle");
    client.send(&[(0x000, &[1, 0])]);
    // 0x605B: ramp to standstill, then switch off.
    assert_eq!(client.sdo([0x2b, 0x5b, 0x60, 0, 1, 0, 0, 0])[0], 0x60);
    client.sdo([0x2f, 0x01, 0x20, 0, 1, 0, 0, 0]);
    let command = |client: &mut Client, word: u8, torque: i16, milliseconds: usize| {
        let [low, high] = torque.to_le_bytes();
        for _ in 0..milliseconds / 4 {
            client.send(&[(0x500 + NODE, &[word, 0, 10, low, high])]);
            client.idle(3);
        }
    };
    for word in [6, 7, 15] {
        command(&mut client, word, 0, 8);
    }
    assert_eq!(client.read(0x6061, 0), 10);
    command(&mut client, 15, 300, 800);
    assert!(client.speed > 0.3, "{} rad/s by torque", client.speed);
    command(&mut client, 6, 0, 8);
    assert_eq!(client.read(0x6041, 0) & 0x6f, 0x27, "it ramps in operation");
    command(&mut client, 6, 0, 600);
    assert_eq!(client.read(0x6041, 0) & 0x6f, 0x21, "ready to switch on");
}

/// Reads an object of any length in segments.
fn upload(client: &mut Client, index: u16) -> Vec<u8> {
    let [low, high] = index.to_le_bytes();
    let first = client.sdo([0x40, low, high, 0, 0, 0, 0, 0]);
    assert_eq!(first[0] & 0xf2, 0x40, "{first:x?} is no segmented upload");
    let (mut bytes, mut toggle) = (Vec::new(), 0);
    loop {
        let segment = client.sdo([0x60 | toggle, 0, 0, 0, 0, 0, 0, 0]);
        let unused = usize::from(segment[0] >> 1 & 7);
        bytes.extend(&segment[1..8 - unused]);
        toggle ^= 0x10;
        if segment[0] & 1 != 0 {
            return bytes;
        }
    }
}

/// Reads all samples of a recording.
fn samples(client: &mut Client) -> Vec<[i16; 4]> {
    (0..8_u8)
        .flat_map(|window| {
            client.sdo([0x2b, 0x62, 0x20, 0, window, 0, 0, 0]);
            let bytes = upload(client, 0x2063);
            assert_eq!((bytes.len(), bytes[0]), (514, window));
            let values = bytes[2..].chunks_exact(2);
            let values: Vec<_> = values
                .map(|value| i16::from_le_bytes([value[0], value[1]]))
                .collect();
            let samples: Vec<[i16; 4]> = values
                .chunks_exact(4)
                .map(|sample| sample.try_into().expect("four values"))
                .collect();
            samples
        })
        .collect()
}

#[test]
fn a_client_records_a_current_step_and_a_fault() {
    let mut client = Client::guarded("axle");
    client.idle(60);
    // Current q, demand, compare a, velocity; every sample; 100 before a fault.
    client.sdo([0x23, 0x60, 0x20, 2, 4, 5, 6, 10]);
    client.sdo([0x2b, 0x60, 0x20, 4, 100, 0, 0, 0]);
    // Recording works although the guard is alive. It arms for a fault.
    assert_eq!(client.sdo([0x2f, 0x60, 0x20, 1, 2, 0, 0, 0])[0], 0x60);
    assert_eq!(client.read(0x2061, 1), 1, "armed");
    for word in [6, 7, 15, 15] {
        client.send(&[(0x300 + NODE, &velocity(word, 0.5))]);
        client.idle(4);
    }
    // Set-points end: fault "command lost".
    client.idle(150);
    assert_eq!(client.read(0x2061, 1), 3, "done");
    assert_eq!(client.read(0x2061, 2), 100);
    assert_eq!(client.read(0x2061, 3), 20_000);
    let samples = samples(&mut client);
    assert_eq!(samples.len(), 512);
    let full_scale = client.read(0x2061, 4) as f32 * 1e-3;
    let amperes = |value: i16| f32::from(value) / 32_768.0 * full_scale;
    for [current, demand, compare, _] in &samples {
        // A model with noise follows its demand.
        let error = amperes(*current) - amperes(*demand);
        assert!(error.abs() < 0.6, "{error} A");
        assert!((1..4_250).contains(compare), "{compare}");
    }
    let [first, last] = [samples[0][3], samples[511][3]];
    assert!(
        first > 20 && last < first,
        "{first} to {last}: it slows down"
    );
}

/// Writes an object in one segment.
fn download(client: &mut Client, index: u16, sub: u8, value: &[u8]) {
    let [low, high] = index.to_le_bytes();
    let answer = client.sdo([0x21, low, high, sub, value.len() as u8, 0, 0, 0]);
    assert_eq!(answer, [0x60, low, high, sub, 0, 0, 0, 0]);
    let mut segment = [0; 8];
    segment[0] = ((7 - value.len()) as u8) << 1 | 1;
    segment[1..=value.len()].copy_from_slice(value);
    assert_eq!(client.sdo(segment)[0], 0x20);
}

#[test]
fn what_a_client_writes_in_segments_takes_effect() {
    let mut client = Client::new("axle");
    client.send(&[(0x000, &[1, 0])]);
    download(&mut client, 0x2001, 0, &[1]);
    client.sdo([0x2f, 0x60, 0x60, 0, 9, 0, 0, 0]);
    download(&mut client, 0x60ff, 0, &500_000_i32.to_le_bytes());
    for word in [6, 7, 15, 15, 15, 15] {
        download(&mut client, 0x6040, 0, &[word, 0]);
    }
    assert_eq!(client.read(0x6041, 0) & 0x6f, 0x27, "operation enabled");
    let torque = |client: &mut Client| {
        client.send(&[]);
        client.read(0x6077, 0) as i16
    };
    let before = torque(&mut client);
    download(&mut client, 0x60b2, 0, &(-300_i16).to_le_bytes());
    let after = torque(&mut client);
    println!("{before} {after}");
    assert!(after < before - 150, "{before} {after}");
    // The command "record now".
    assert_eq!(client.read(0x2061, 1), 0, "idle");
    download(&mut client, 0x2060, 1, &[1]);
    assert_ne!(client.read(0x2061, 1), 0, "it records");
}

#[test]
fn a_mapping_that_is_longer_than_a_frame_is_refused() {
    let mut client = Client::new("axle");
    let too_long = 0x0604_0042;
    let map = |client: &mut Client, entry: u8, object: u32| {
        let [a, b, c, d] = object.to_le_bytes();
        client.sdo([0x23, 0x03, 0x1a, entry, a, b, c, d])
    };
    let count = |client: &mut Client, count| client.sdo([0x2f, 0x03, 0x1a, 0, count, 0, 0, 0]);
    // Position, velocity and statusword: 4, 4 and 2 bytes.
    assert_eq!(count(&mut client, 0)[0], 0x60);
    for (entry, object) in [(1, 0x6064_0020), (2, 0x606c_0020), (3, 0x6041_0010)] {
        assert_eq!(map(&mut client, entry, object)[0], 0x60);
    }
    assert_eq!(Client::abort_code(count(&mut client, 3)), too_long);
    assert_eq!(client.read(0x1a03, 0), 0);
    assert_eq!(count(&mut client, 2)[0], 0x60);
    // An entry is written only while the PDO has no objects.
    let answer = map(&mut client, 2, 0x6041_0010);
    assert_eq!(Client::abort_code(answer), DEVICE_STATE);
    assert_eq!(count(&mut client, 0)[0], 0x60);
    assert_eq!(map(&mut client, 2, 0x6041_0010)[0], 0x60);
    assert_eq!(count(&mut client, 3)[0], 0x60);
}
