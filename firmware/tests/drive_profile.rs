//! Tests of the drive profile (CiA 402) as a client sees it that commands one drive in bench mode,
//! by SDO, as a person with a terminal does.

mod node;

use node::{MOTOR, Node, settings};
use tautrack::can::Frame;
use tautrack::link::Sensors;
use tautrack::sensors::Switches;
use tautrack::settings::Setting;

const NODE: u16 = 5;

/// Objects, with their sizes.
const BENCH: (u16, u8) = (0x2001, 1);
const CONTROLWORD: (u16, u8) = (0x6040, 2);
const MODE: (u16, u8) = (0x6060, 1);
const TORQUE: (u16, u8) = (0x6071, 2);
const POSITION: (u16, u8) = (0x607a, 4);
const VELOCITY: (u16, u8) = (0x60ff, 4);
const METHOD: (u16, u8) = (0x6098, 1);

const OPERATION_ENABLED: u16 = 0x27;

struct Client {
    node: Node,
    /// Turns of the output shaft.
    turns: f64,
    speed: f32,
    /// Where the home switch closes, turns.
    home: f64,
}

impl Client {
    /// A drive in bench mode, which waits a second for the next command.
    fn new(changes: &[(Setting, i32)]) -> Self {
        let mut node = Node::host("axle");
        let mut values = settings(i32::from(NODE));
        let own = [
            (Setting::CommandTimeout, 1_000),
            (Setting::BenchSpeed, 5_000),
        ];
        let keys = own.iter().chain(changes);
        values.extend(keys.map(|(setting, value)| (setting.description().key, *value)));
        assert_eq!(node.start(&values, Some(MOTOR)), "");
        let mut client = Self {
            node,
            turns: 0.0,
            speed: 0.0,
            home: f64::INFINITY,
        };
        client.run(3, &[]);
        client.write(BENCH, 1);
        client
    }

    fn run(&mut self, steps: usize, frames: &[Frame]) -> Vec<Frame> {
        let mut sent = Vec::new();
        for step in 0..steps {
            let sensors = Sensors {
                supply_voltage: 24.0,
                switches: Switches {
                    home: self.turns > self.home,
                    ..Switches::default()
                },
                ..Sensors::default()
            };
            let stepped = self
                .node
                .step(sensors, if step == 0 { frames } else { &[] });
            self.turns = stepped.shaft.position as f64 / (1_u64 << 32) as f64;
            self.speed = stepped.shaft.velocity;
            sent.extend(stepped.frames);
        }
        sent
    }

    fn request(&mut self, request: [u8; 8]) -> [u8; 8] {
        let request = Frame::new(0x600 + NODE, &request).expect("a frame");
        let frames = self.run(3, &[request]);
        let answer = frames.iter().find(|frame| frame.id() == 0x580 + NODE);
        answer.expect("an answer").data().try_into().expect("eight")
    }

    fn write(&mut self, (index, size): (u16, u8), value: i32) {
        assert_eq!(
            self.try_write((index, 0, size), value),
            None,
            "{index:#x} = {value}"
        );
    }

    /// Writes an object; returns the abort code.
    fn try_write(&mut self, (index, sub, size): (u16, u8, u8), value: i32) -> Option<u32> {
        let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), value.to_le_bytes());
        let command = 0x23 | (4 - size) << 2;
        let answer = self.request([command, low, high, sub, a, b, c, d]);
        (answer[0] != 0x60).then(|| u32::from_le_bytes(answer[4..].try_into().expect("four")))
    }

    fn read(&mut self, index: u16, sub: u8) -> i32 {
        let [low, high] = index.to_le_bytes();
        let answer = self.request([0x40, low, high, sub, 0, 0, 0, 0]);
        let size = 4 - usize::from(answer[0] >> 2 & 3);
        let mut bytes = [0; 4];
        bytes[..size].copy_from_slice(&answer[4..4 + size]);
        i32::from_le_bytes(bytes)
    }

    fn statusword(&mut self) -> u16 {
        self.read(0x6041, 0) as u16
    }

    /// Leads the drive to operation.
    fn enable(&mut self) {
        self.write(BENCH, 1);
        for word in [0x06, 0x07, 0x0f] {
            self.write(CONTROLWORD, word);
        }
        let error = self.read(0x603f, 0);
        assert_eq!(
            self.statusword() & 0x6f,
            OPERATION_ENABLED,
            "error {error:#x}"
        );
    }

    /// Writes a target in each SYNC period, as cyclic modes ask for it.
    fn command(&mut self, target: (u16, u8), value: i32) {
        for _ in 0..100 {
            self.write(target, value);
        }
    }

    /// Waits until the drive stands. Returns where.
    fn stand(&mut self) -> f64 {
        let mut waits = 0..200;
        while waits.next().is_some() && self.speed.abs() > 1e-3 {
            self.run(50, &[]);
        }
        assert!(self.speed.abs() < 0.02, "{} rad/s", self.speed);
        self.turns
    }

    /// Asserts that the drive stands where it is, for half a second.
    fn stays(&mut self, why: &str) {
        let before = self.turns;
        for _ in 0..10 {
            self.run(50, &[]);
            let moved = (self.turns - before).abs();
            assert!(moved < 1e-3, "{why}: moved by {moved} turns");
        }
    }
}

/// Modes in which a target acts for as long as it stands in its object.
const MODES: [(i32, (u16, u8), i32); 4] = [
    (8, POSITION, 0x300),
    (9, VELOCITY, 2_000_000),
    (3, VELOCITY, 2_000_000),
    (10, TORQUE, 200),
];

#[test]
fn enabling_a_drive_never_moves_it_to_a_target_from_before() {
    for (mode, target, value) in MODES {
        // A drive without a home switch is homed from the start.
        let mut client = Client::new(&[(Setting::HomingDirection, 0)]);
        client.write(MODE, mode);
        client.enable();
        client.stays("before there is a target");
        client.command(target, value);
        assert!(client.turns.abs() > 0.01, "mode {mode} does not move it");
        client.write(CONTROLWORD, 0x00);
        let place = client.stand();
        client.enable();
        client.stays("enabled again");
        assert!((client.turns - place).abs() < 1e-3, "mode {mode}");
        // The same target moves it once it is written.
        client.command(target, if target == POSITION { 0 } else { value });
        assert!((client.turns - place).abs() > 0.01, "mode {mode}");
    }
}

#[test]
fn a_target_that_is_written_before_operation_counts() {
    let mut client = Client::new(&[(Setting::HomingDirection, 0)]);
    client.write(MODE, 1);
    client.write(POSITION, 0x1000);
    client.enable();
    client.write(CONTROLWORD, 0x1f);
    client.run(500, &[]);
    assert!((client.turns - 0.0625).abs() < 1e-3, "{}", client.turns);
    // In the next operation this target is an old one.
    client.write(CONTROLWORD, 0x00);
    client.write(POSITION, 0);
    client.enable();
    client.write(CONTROLWORD, 0x1f);
    client.run(500, &[]);
    assert!(client.turns.abs() < 1e-3, "{}", client.turns);
    client.write(CONTROLWORD, 0x00);
    client.enable();
    client.write(CONTROLWORD, 0x1f);
    client.stays("a new set-point without a target");
}

#[test]
fn a_change_of_mode_never_moves_a_drive_to_a_target_of_another_mode() {
    let mut client = Client::new(&[(Setting::HomingDirection, 0)]);
    client.write(MODE, 8);
    client.write(POSITION, 0);
    client.enable();
    // Turns away from the target, and stands.
    client.write(MODE, 9);
    client.write(VELOCITY, 2_000_000);
    client.run(400, &[]);
    client.write(VELOCITY, 0);
    client.stand();
    assert!(client.turns > 0.05, "{}", client.turns);
    client.write(MODE, 8);
    client.stays("in cyclic position mode");
    assert_eq!(client.read(0x60ff, 0), 0);
    client.write(MODE, 9);
    client.stays("in cyclic velocity mode");
}

#[test]
fn a_drive_that_is_turned_by_hand_while_it_is_off_stays_where_it_is() {
    let mut client = Client::new(&[(Setting::HomingDirection, 0)]);
    client.write(MODE, 8);
    client.enable();
    client.write(CONTROLWORD, 0x00);
    for _ in 0..300 {
        let sensors = Sensors {
            supply_voltage: 24.0,
            shaft_torque: -4.0,
            ..Sensors::default()
        };
        client.node.step(sensors, &[]);
    }
    client.run(1, &[]);
    client.stand();
    assert!(client.turns.abs() > 0.01, "{} turns", client.turns);
    client.enable();
    client.stays("after it was turned");
}

/// Bits 13, 12 and 10 of the statusword.
fn homing_bits(client: &mut Client) -> [bool; 3] {
    let word = client.statusword();
    [13, 12, 10].map(|bit| word >> bit & 1 != 0)
}

/// CiA 402-2, table of the homing mode.
#[test]
fn the_statusword_tells_the_phase_of_homing() {
    let mut client = Client::new(&[(Setting::HomingDirection, 1)]);
    client.write(MODE, 6);
    client.enable();
    assert_eq!(
        homing_bits(&mut client),
        [false, false, true],
        "not started"
    );
    client.write(CONTROLWORD, 0x1f);
    client.run(100, &[]);
    assert_eq!(homing_bits(&mut client), [false; 3], "under way");
    // Halt.
    client.write(CONTROLWORD, 0x11f);
    client.stand();
    assert_eq!(
        homing_bits(&mut client),
        [false, false, true],
        "interrupted"
    );
    client.write(CONTROLWORD, 0x0f);
    client.home = client.turns + 0.02;
    client.write(CONTROLWORD, 0x1f);
    for _ in 0..20 {
        client.write(MODE, 6);
        client.run(400, &[]);
    }
    assert_eq!(homing_bits(&mut client), [false, true, true], "attained");
    // Without an end of the search: the time runs out.
    client.home = f64::INFINITY;
    client.write(CONTROLWORD, 0x0f);
    client.write(CONTROLWORD, 0x1f);
    let mut seen = Vec::new();
    for _ in 0..50 {
        client.write(MODE, 6);
        client.run(450, &[]);
        let bits = homing_bits(&mut client);
        if seen.last() != Some(&bits) {
            seen.push(bits);
        }
    }
    assert_eq!(seen.last(), Some(&[true, false, true]), "failed: {seen:?}");
}

#[test]
fn the_homing_method_of_an_axle_without_a_reference_can_be_written_back() {
    let mut client = Client::new(&[(Setting::HomingDirection, 0)]);
    let method = client.read(0x6098, 0);
    assert_eq!(method, 0);
    client.write(METHOD, method);
    // There is nothing to look for.
    client.write(MODE, 6);
    client.enable();
    client.write(CONTROLWORD, 0x1f);
    assert_eq!(homing_bits(&mut client), [false, true, true]);
    client.stays("homing without a method");
    // A drive with a reference cannot be homed without a method.
    let mut client = Client::new(&[(Setting::HomingDirection, 1)]);
    client.write(METHOD, 0);
    client.write(MODE, 6);
    client.enable();
    client.write(CONTROLWORD, 0x1f);
    assert_eq!(homing_bits(&mut client), [true, false, true]);
}

/// Position of the state "fault" in the statusword, of CiA 402.
const FAULT: u16 = 0x08;

#[test]
fn a_fault_that_holds_is_seen_and_reset_by_a_client_of_the_profile() {
    let mut client = Client::new(&[(Setting::HomingDirection, 0)]);
    client.write(MODE, 9);
    client.enable();
    client.write(VELOCITY, 1_000_000);
    // The client falls silent for longer than a second.
    client.run(1_200, &[]);
    assert_eq!(client.read(0x603f, 0), 0x8250);
    assert_eq!(client.statusword() & 0x4f, FAULT);
    client.stays("it holds");
    // As `reset_from_fault` of python-canopen does: disable voltage, then a rising edge.
    client.write(CONTROLWORD, 0x00);
    assert_eq!(client.statusword() & 0x4f, FAULT, "until it is reset");
    client.write(CONTROLWORD, 0x80);
    assert_eq!(client.statusword() & 0x4f, 0x40, "switch on disabled");
    client.enable();
    client.stays("after the reset");
}

const PROFILE_VELOCITY: (u16, u8) = (0x6081, 4);
const PROFILE_ACCELERATION: (u16, u8) = (0x6083, 4);

/// Greatest speed, rad/s, and greatest change of it in 10 ms, rad/s, of a motion of half a turn.
fn motion(client: &mut Client, mode: i32) -> (f32, f32) {
    client.write(MODE, mode);
    client.enable();
    let (mut fastest, mut change) = (0.0_f32, 0.0_f32);
    let (target, value) = match mode {
        1 => (POSITION, 0x8000),
        _ => (VELOCITY, 4_000_000),
    };
    client.write(target, value);
    client.write(CONTROLWORD, 0x1f);
    let mut before = client.speed;
    for _ in 0..60 {
        client.run(10, &[]);
        fastest = fastest.max(client.speed.abs());
        change = change.max((client.speed - before).abs());
        before = client.speed;
    }
    (fastest, change)
}

#[test]
fn a_profile_stays_within_its_velocity_and_acceleration() {
    for mode in [1, 3, 9] {
        let profile = mode != 9;
        let mut client = Client::new(&[(Setting::HomingDirection, 0)]);
        let (fast, steep) = motion(&mut client, mode);
        assert!(
            fast > 3.0 && steep > 0.15,
            "mode {mode}: {fast} rad/s, {steep}"
        );
        let mut client = Client::new(&[(Setting::HomingDirection, 0)]);
        client.write(PROFILE_VELOCITY, 1_000_000);
        client.write(PROFILE_ACCELERATION, 5_000_000);
        let (fast, steep) = motion(&mut client, mode);
        // Half a turn takes longer than the time that is watched.
        assert_eq!(
            (0.9..1.1).contains(&fast),
            profile,
            "mode {mode}: {fast} rad/s"
        );
        assert_eq!(
            (0.03..0.09).contains(&steep),
            profile,
            "mode {mode}: {steep}"
        );
    }
}

#[test]
fn a_halt_halts_in_cyclic_position_mode_though_targets_go_on() {
    let mut client = Client::new(&[(Setting::HomingDirection, 0)]);
    client.write(MODE, 8);
    client.enable();
    client.write(CONTROLWORD, 0x10f);
    client.command(POSITION, 0x400);
    assert!(client.turns.abs() < 1e-3, "{} turns", client.turns);
}

#[test]
fn a_target_of_another_client_or_of_the_guard_is_forgotten() {
    let mut client = Client::new(&[(Setting::HomingDirection, 0)]);
    // A client writes a target and leaves. Bench mode ends.
    client.write(MODE, 8);
    client.write(POSITION, 0x400);
    client.run(1_200, &[]);
    client.enable();
    client.stays("after another client");
    client.write(CONTROLWORD, 0x00);
    // A guard sends targets to a drive that it does not lead up, and goes.
    for step in 0..100 {
        let guard = Frame::new(0x701, &[5]).expect("a frame");
        let hold = Frame::new(0x200 + NODE, &[0, 0, 8, 0, 4, 0, 0]).expect("a frame");
        if step % 10 == 0 {
            client.run(1, &[guard]);
        }
        client.run(4, &[hold]);
    }
    client.run(300, &[]);
    // The fault "guard lost" is reset.
    client.write(CONTROLWORD, 0x80);
    client.write(MODE, 8);
    client.enable();
    client.command(CONTROLWORD, 0x0f);
    client.stays("after the guard");
}
