//! Any frames, at any time, to a whole drive with its motor, and to a guard. Half of the frames
//! have an identifier that the node receives. With `TAUTRACK_SWEEPS=1` ten million frames, else a
//! fiftieth.

mod node;

use node::{MOTOR, Node, settings};
use tautrack::can::Frame;
use tautrack::link::{BodyMeasurands, Sensors};

const NODE: u8 = 5;
const GUARD: u8 = 1;

/// Frames for each of the five kinds of sequences.
fn frames() -> u64 {
    let whole = std::env::var_os("TAUTRACK_SWEEPS").is_some();
    if whole { 2_000_000 } else { 40_000 }
}

/// xorshift64*.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    fn below(&mut self, bound: u64) -> u64 {
        (self.bits() >> 32) % bound
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len() as u64) as usize]
    }
}

/// What a sequence leaves out.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Without {
    /// Neither bench mode nor a guard's heartbeat: nobody is in command.
    Command,
    /// No controlword enables operation.
    Enabling,
    /// The guard lives and holds the drive. Other nodes send no heartbeat of it.
    Guard,
    Nothing,
}

const WORDS: [u8; 10] = [0x00, 0x02, 0x06, 0x07, 0x0f, 0x1f, 0x3f, 0x80, 0x8f, 0x10];
const INDICES: [u16; 24] = [
    0x1003, 0x1011, 0x1014, 0x1016, 0x1017, 0x1400, 0x1401, 0x1600, 0x1601, 0x1800, 0x1a00, 0x2050,
    0x2060, 0x2065, 0x2101, 0x605a, 0x6060, 0x6065, 0x6071, 0x607a, 0x607d, 0x6081, 0x6098, 0x60ff,
];

/// Whether the low bits of a controlword enable operation.
fn enables(word: u8) -> bool {
    word & 0x0f == 0x0f
}

fn frame(random: &mut Random, without: Without) -> Frame {
    let any = random.bits().to_le_bytes();
    let own = u16::from(NODE);
    let word = loop {
        let word = random.pick(&WORDS);
        if without != Without::Enabling || !enables(word) {
            break word;
        }
    };
    let mode = random.pick(&[1, 3, 6, 8, 9, 10, 0, 99, 0xff]);
    let (id, data): (u16, Vec<u8>) = match random.below(24) {
        0 => {
            let command = random.pick(&[1, 1, 1, 1, 2, 128, 129, 130]);
            (0x000, vec![command, random.pick(&[0, NODE, NODE, 7])])
        }
        1 | 2 => (0x080, Vec::new()),
        3 if !matches!(without, Without::Command | Without::Guard) => {
            (0x700 + u16::from(GUARD), vec![random.pick(&[5, 5, 5, 127])])
        }
        4..=7 => {
            let id = random.pick(&[0x200, 0x300, 0x400, 0x500]) + own;
            let mut data = vec![word, 0, mode];
            data.extend(&any[..random.pick(&[2, 4, 4, 4, 5])]);
            (id, data)
        }
        8 if without != Without::Command => (
            0x600 + own,
            vec![0x2f, 0x01, 0x20, 0, random.pick(&[1, 1, 0]), 0, 0, 0],
        ),
        9 => (0x600 + own, vec![0x2b, 0x40, 0x60, 0, word, 0, 0, 0]),
        10 | 11 => {
            let [low, high] = random.pick(&INDICES).to_le_bytes();
            let command = random.pick(&[0x22, 0x23, 0x2b, 0x2f, 0x40, 0x21, 0xc2, 0xa0]);
            let mut data = vec![command, low, high, random.below(4) as u8];
            data.extend(&any[..4]);
            (0x600 + own, data)
        }
        12 => (0x7e5, any.to_vec()),
        _ => {
            let id = random.below(0x800) as u16;
            (id, any[..random.below(9) as usize].to_vec())
        }
    };
    Frame::new(id, &data).expect("a frame")
}

/// Whether a sequence leaves this frame out.
fn is_left_out(frame: &Frame, without: Without) -> bool {
    let (id, data) = (frame.id(), frame.data());
    let own = u16::from(NODE);
    let command =
        matches!(without, Without::Command | Without::Guard) && id == 0x700 + u16::from(GUARD);
    // A random mapping could reach any object.
    let parameter = without != Without::Nothing && id == 0x600 + own && data.get(2) == Some(&0x16);
    let bench = without == Without::Command && id == 0x600 + own && data.get(2) == Some(&0x20);
    let process_data = matches!(id & !0x7f, 0x200 | 0x300 | 0x400 | 0x500) && id & 0x7f == own;
    let enabling = without == Without::Enabling
        && (process_data && data.first().is_some_and(|word| enables(*word))
            || id == 0x600 + own && data.get(1..3) == Some(&[0x40, 0x60]) && enables(data[4]));
    command || parameter || bench || enabling
}

/// What a client sends in this step that turns a drive in bench mode.
fn client(step: u64) -> Option<Frame> {
    let own = u16::from(NODE);
    let bench = [0x2f, 0x01, 0x20, 0, 1, 0, 0, 0];
    let word = *[0x80, 0x00, 0x06, 0x07]
        .get(step as usize / 20)
        .unwrap_or(&0x0f);
    let [a, b, c, d] = 900_000_i32.to_le_bytes();
    match step {
        2 => Frame::new(0x000, &[1, NODE]),
        3 | 33 => Frame::new(0x600 + own, &bench),
        _ if step.is_multiple_of(4) => Frame::new(0x300 + own, &[word, 0, 9, a, b, c, d]),
        _ => None,
    }
}

/// Runs a drive. Returns the greatest speed, rad/s, and the greatest distance from the start,
/// turns.
fn drive(without: Without, seed: u64) -> (f32, f64) {
    let mut random = Random(seed);
    let mut node = Node::host("axle");
    assert_eq!(node.start(&settings(NODE.into()), Some(MOTOR)), "");
    let (mut fastest, mut farthest) = (0.0_f32, 0.0_f64);
    let mut sent = 0;
    let mut steps = 0_u64;
    while sent < frames() {
        steps += 1;
        let mut frames = Vec::new();
        if without == Without::Guard {
            if steps.is_multiple_of(50) || steps < 3 {
                frames.push(Frame::new(0x700 + u16::from(GUARD), &[5]).expect("a frame"));
            }
            if steps.is_multiple_of(4) {
                // "Quick stop" in cyclic velocity mode.
                let hold = [0x02, 0, 9, 0, 0, 0, 0];
                frames.push(Frame::new(0x300 + u16::from(NODE), &hold).expect("a frame"));
            }
        }
        // A client that commands in order, for every other half second. Few others disturb it.
        let orderly = without == Without::Nothing && steps % 1_000 < 500;
        if orderly {
            frames.extend(client(steps % 1_000));
        }
        let others = if orderly {
            u64::from(random.below(40) == 0)
        } else {
            random.below(8)
        };
        for _ in 0..others {
            let frame = frame(&mut random, without);
            if !is_left_out(&frame, without) {
                frames.push(frame);
            }
            sent += 1;
        }
        let sensors = Sensors {
            supply_voltage: 24.0,
            ..Sensors::default()
        };
        let stepped = node.step(sensors, &frames);
        fastest = fastest.max(stepped.shaft.velocity.abs());
        let turns = stepped.shaft.position as f64 / (1_u64 << 32) as f64;
        farthest = farthest.max(turns.abs());
    }
    (fastest, farthest)
}

#[test]
fn no_frames_move_a_drive_that_nobody_commands() {
    let (speed, turns) = drive(Without::Command, 1);
    assert!(speed < 1e-3 && turns < 1e-5, "{speed} rad/s, {turns} turns");
}

#[test]
fn no_frames_move_a_drive_that_nobody_enables() {
    let (speed, turns) = drive(Without::Enabling, 2);
    assert!(speed < 1e-3 && turns < 1e-5, "{speed} rad/s, {turns} turns");
}

/// Frames of others can enable a drive for the time between two frames of its guard. It moves by
/// less than two degrees.
#[test]
fn no_frames_of_others_move_a_drive_that_its_guard_holds() {
    let (speed, turns) = drive(Without::Guard, 3);
    assert!(speed < 0.5 && turns < 0.005, "{speed} rad/s, {turns} turns");
}

/// The velocity limit is 6 rad/s.
#[test]
fn no_frames_make_a_drive_panic_or_faster_than_its_limit() {
    let (speed, _) = drive(Without::Nothing, 4);
    assert!((0.5..7.0).contains(&speed), "{speed} rad/s");
}

/// The guard's operator is silent, so it leads no drive up.
#[test]
fn no_frames_make_a_guard_panic_or_enable_a_drive() {
    let mut random = Random(5);
    let mut node = Node::host("guard");
    assert_eq!(node.start(&settings(NODE.into()), None), "");
    let (mut sent, mut steps) = (0, 0_u32);
    while sent < frames() {
        steps += 1;
        let mut given = Vec::new();
        for _ in 0..random.below(8) {
            sent += 1;
            let frame = frame(&mut random, Without::Nothing);
            let id = frame.id();
            // The operator: process data, and the objects of its command.
            let operator = id & !0x7f == 0x200 && id & 0x7f == u16::from(NODE)
                || id == 0x600 + u16::from(NODE)
                    && frame
                        .data()
                        .get(2)
                        .is_some_and(|high| matches!(high, 0x14..=0x17 | 0x40));
            if !operator {
                given.push(frame);
            }
        }
        // The drives' status and motion.
        if steps.is_multiple_of(4) {
            let drive = 2 + random.below(4) as u16;
            let kind = random.pick(&[0x180, 0x280, 0x700]);
            let any = random.bits().to_le_bytes();
            let length = if kind == 0x700 { 1 } else { 8 };
            given.push(Frame::new(kind + drive, &any[..length]).expect("a frame"));
        }
        let noise = (steps * 7 % 13) as f32 * 1e-3;
        let sensors = Sensors {
            body: Some(BodyMeasurands {
                tilt_force: [noise, 0.0, 9.81],
                specific_force: [noise, noise, 9.81 + noise],
                angular_rate: [noise; 3],
                ..BodyMeasurands::default()
            }),
            ..Sensors::default()
        };
        for frame in node.step(sensors, &given).frames {
            let set_point = matches!(frame.id() & !0x7f, 0x200 | 0x300);
            let enabling = frame.data().first().is_some_and(|word| enables(*word));
            assert!(!(set_point && enabling), "step {steps}: {frame:?}");
        }
    }
}
