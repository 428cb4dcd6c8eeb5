//! Calibrates the motors of nodes over the bus, as a CANopen client does.

mod node;

use node::{MOTOR, Node, settings};
use tautrack::can::Frame;
use tautrack::link::{MotorModel, Sensors, ThreePhaseModel, WindingModel};
use tautrack::settings::Setting;

const NODE: u16 = 5;

/// Winding of a three-phase motor with 0.063 N m/A.
const WINDING: ThreePhaseModel = ThreePhaseModel {
    resistance: 0.3,
    inductance: [4e-4, 5e-4],
    flux: 0.006,
    pole_pairs: 7,
    offset_degrees: 71.0,
    cogging_torque: 0.005,
    cogging_periods: 42,
};

struct Client {
    node: Node,
    steps: u32,
    /// Whether the client sends set-points that keep bench mode alive.
    attends: bool,
    /// True speed of the output shaft, rad/s.
    speed: f32,
}

impl Client {
    /// Starts an axle whose settings differ from those of [`settings`] in these values.
    fn new(motor: MotorModel, changes: &[(Setting, i32)]) -> Self {
        Self::of("axle", motor, changes)
    }

    /// Starts a drive with this role, as [`Self::new`] does.
    fn of(role: &'static str, motor: MotorModel, changes: &[(Setting, i32)]) -> Self {
        let mut values = settings(i32::from(NODE));
        values.extend(
            [
                (Setting::CalibrationCurrent, 6_000),
                (Setting::CalibrationSpeed, 6_000),
            ]
            .iter()
            .chain(changes)
            .map(|(setting, value)| (setting.description().key, *value)),
        );
        let mut node = Node::host(role);
        assert_eq!(node.start(&values, Some(motor)), "");
        let mut client = Self {
            node,
            steps: 0,
            attends: true,
            speed: 0.0,
        };
        client.send(&[(0x000, &[1, 0])]);
        client
    }

    fn send(&mut self, frames: &[(u16, &[u8])]) -> Vec<Frame> {
        self.steps += 1;
        // "Disable voltage", which keeps the drive disarmed.
        let attends = (self.attends && self.steps.is_multiple_of(20))
            .then_some((0x300 + NODE, [0; 7].as_slice()));
        let frames: Vec<_> = attends
            .iter()
            .chain(frames)
            .map(|(id, data)| Frame::new(*id, data).expect("a frame"))
            .collect();
        let sensors = Sensors {
            supply_voltage: 24.0,
            ..Sensors::default()
        };
        let stepped = self.node.step(sensors, &frames);
        self.speed = stepped.shaft.velocity;
        stepped.frames.to_vec()
    }

    fn sdo(&mut self, request: [u8; 8]) -> [u8; 8] {
        let mut frames = self.send(&[(0x600 + NODE, &request)]);
        for _ in 0..5 {
            frames.extend(self.send(&[]));
        }
        let answer = frames.iter().find(|frame| frame.id() == 0x580 + NODE);
        let data = answer.expect("an answer within 5 ms").data();
        data.try_into().expect("eight bytes")
    }

    fn read(&mut self, index: u16) -> i32 {
        let [low, high] = index.to_le_bytes();
        let answer = self.sdo([0x40, low, high, 0, 0, 0, 0, 0]);
        i32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]])
    }

    fn write(&mut self, index: u16, value: u8) {
        let [low, high] = index.to_le_bytes();
        assert_eq!(
            self.sdo([0x2f, low, high, 0, value, 0, 0, 0])[0],
            0x60,
            "{index:#x}"
        );
    }

    /// Calibrates everything in bench mode, and asserts that it is done.
    fn calibrate_all(&mut self) {
        self.write(0x2001, 1);
        self.write(0x2050, 2);
        let end = self.end();
        let refused = [self.read(0x2053), self.read(0x2054)];
        assert_eq!(end, (100, 0), "{refused:?}");
    }

    /// Waits for the end of the calibration; returns its progress and the reason of a refusal.
    fn end(&mut self) -> (i32, i32) {
        for _ in 0..1_000 {
            for _ in 0..100 {
                self.send(&[]);
            }
            let progress = self.read(0x2051) & 0xff;
            if progress >= 100 {
                assert_eq!(self.read(0x2050) & 0xff, 0, "the request ends");
                return (progress, self.read(0x2052) & 0xff);
            }
        }
        panic!("the calibration does not end");
    }

    /// Enables the drive in bench mode, and lets it turn with this velocity for some steps, ms.
    fn enable(&mut self, velocity: i32, steps: u32) {
        self.attends = false;
        for controlword in [6, 7] {
            self.command(controlword, velocity);
        }
        self.drive(velocity, steps);
    }

    /// Lets the enabled drive turn with this velocity for some steps, ms.
    fn drive(&mut self, velocity: i32, steps: u32) {
        for _ in 0..steps {
            self.command(15, velocity);
        }
    }

    fn command(&mut self, controlword: u8, velocity: i32) {
        let (identifier, payload) = set_point(controlword.into(), 9, velocity);
        self.send(&[(identifier, &payload)]);
    }

    /// Asserts that the values of these objects are within a part of the expected ones.
    fn assert_near(&mut self, expected: &[(u16, f64, f64)]) {
        for (index, value, part) in expected {
            let got = f64::from(self.read(*index));
            let off = (got - value).abs();
            assert!(
                off <= part * value.abs(),
                "{index:#x}: {got}, expected {value}"
            );
        }
    }
}

#[test]
fn a_client_calibrates_a_brushed_motor() {
    let mut client = Client::new(
        MotorModel {
            dead_time: 0.6e-6,
            ..MOTOR
        },
        // R +40 %, torque constant -10 %.
        &[
            (Setting::Resistance, 420),
            (Setting::TorqueConstant, 45_000),
        ],
    );
    client.calibrate_all();
    client.assert_near(&[
        (0x2058, 300.0, 0.05),
        (0x2059, 200.0, 0.10),
        (0x205e, 50_000.0, 0.03),
    ]);
}

#[test]
fn a_client_calibrates_a_three_phase_motor_and_then_drives_it() {
    let mut client = Client::new(
        MotorModel {
            winding: WindingModel::ThreePhase(WINDING),
            dead_time: 0.6e-6,
            ..MOTOR
        },
        // With these pole pairs and this offset the motor would not turn as commanded.
        &[
            (Setting::MotorKind, 1),
            (Setting::PolePairs, 4),
            (Setting::ElectricalOffset, -30_000),
            (Setting::Resistance, 420),
        ],
    );
    client.calibrate_all();
    client.assert_near(&[
        (0x2058, 300.0, 0.05),
        (0x2059, 400.0, 0.10),
        (0x205a, 500.0, 0.10),
        (0x205b, 7.0, 0.0),
        (0x205c, 1.0, 0.0),
        // Half a count is 0.3 degrees.
        (0x205d, 71_300.0, 2.0 / 71.3),
        (0x205e, 63_000.0, 0.03),
    ]);
    // The values are in use: in bench mode the motor turns with the commanded speed.
    client.enable(500_000, 500); // 0.5 rad/s
    client.assert_near(&[(0x606c, 500_000.0, 0.05)]);
}

/// Settings of a screw with [`WINDING`], whose lead is 5 mm. Pole pairs, offset and torque constant
/// are wrong.
const SCREW: [(Setting, i32); 7] = [
    (Setting::ScrewLead, 5_000),
    (Setting::MotorKind, 1),
    (Setting::PolePairs, 4),
    (Setting::ElectricalOffset, -30_000),
    (Setting::Resistance, 420),
    (Setting::TorqueConstant, 45_000),
    (Setting::CoggingPeriods, 6),
];
/// Velocity on the bus, 1e-9 m/s: 0.2 rad/s of the shaft of such a screw.
const SCREW_VELOCITY: i32 = 159_155;

#[test]
fn a_client_calibrates_the_motor_of_a_screw_and_then_drives_it() {
    let motor = MotorModel {
        winding: WindingModel::ThreePhase(WINDING),
        dead_time: 0.6e-6,
        ..MOTOR
    };
    let mut client = Client::of("screw", motor, &SCREW);
    client.calibrate_all();
    client.assert_near(&[
        (0x205b, 7.0, 0.0),
        (0x205d, 71_300.0, 2.0 / 71.3),
        (0x205e, 63_000.0, 0.03),
    ]);
    // The values are in use: in bench mode the screw moves with the commanded velocity, 0.2 rad/s
    // of its shaft.
    client.enable(SCREW_VELOCITY, 500);
    client.assert_near(&[(0x606c, f64::from(SCREW_VELOCITY), 0.05)]);
    // The force at the nut is computed with the new torque constant and a gear of 50. Cogging
    // changes it from reading to reading.
    let newtons_per_ampere = 0.063 * 50.0 * 2.0 * std::f64::consts::PI / 0.005;
    let (mut newtons, mut amperes) = (0.0, 0.0);
    for _ in 0..200 {
        client.drive(SCREW_VELOCITY, 7);
        newtons += f64::from(client.read(0x6077));
        amperes += f64::from(client.read(0x6078)) * 1e-3;
    }
    // The friction of 1 N m takes 0.3 A.
    assert!(amperes > 200.0 * 0.25, "{amperes}");
    let expected = amperes * newtons_per_ampere;
    assert!(
        (newtons / expected - 1.0).abs() < 0.04,
        "{newtons}, expected {expected}"
    );
}

#[test]
fn a_client_finds_the_cogging_torque_of_a_screw() {
    let winding = ThreePhaseModel {
        cogging_torque: 0.02,
        ..WINDING
    };
    let motor = MotorModel {
        winding: WindingModel::ThreePhase(winding),
        ..MOTOR
    };
    let sound = [
        (Setting::PolePairs, 7),
        (Setting::ElectricalOffset, 71_000),
        (Setting::TorqueConstant, 63_000),
        (Setting::Resistance, 300),
    ];
    let settings: Vec<_> = SCREW.into_iter().chain(sound).collect();
    let mut client = Client::of("screw", motor, &settings);
    client.write(0x2001, 1);
    client.enable(SCREW_VELOCITY, 1_000);
    client.write(0x2065, 1);
    client.drive(SCREW_VELOCITY, 100);
    assert_eq!(client.read(0x2066) & 0xff, 1, "it is under way");
    client.drive(SCREW_VELOCITY, 24_000);
    assert_eq!(client.read(0x2066) & 0xff, 2, "it is done");
    assert_eq!(client.read(0x2065) & 0xff, 0, "the request ends");
    let left = client.read(0x2069) & 0xffff;
    assert!(left < 300, "{left} thousandths of the ripple are left");
}

#[test]
fn a_calibration_that_must_not_turn_the_shaft_far_hardly_moves_a_screw() {
    let mut client = Client::of("screw", MOTOR, &[(Setting::ScrewLead, 5_000)]);
    client.write(0x2001, 1);
    let start = client.read(0x6064);
    client.write(0x2050, 1);
    let mut moved = 0;
    while client.read(0x2051) & 0xff < 100 {
        moved = moved.max((client.read(0x6064) - start).abs());
    }
    assert_eq!(client.end(), (100, 0));
    client.assert_near(&[(0x2058, 300.0, 0.05), (0x205e, 0.0, 0.0)]);
    // 5 um, in 2^-24 m.
    assert!((1..84).contains(&moved), "{moved}");
}

#[test]
fn a_calibration_needs_bench_mode_and_ends_with_it() {
    const ENDED: (i32, i32) = (101, 122);
    let mut client = Client::new(MOTOR, &[]);
    client.write(0x2050, 1);
    assert_eq!(client.end(), ENDED, "without bench mode");
    client.write(0x2001, 1);
    client.write(0x2050, 1);
    for _ in 0..1_000 {
        client.send(&[]);
    }
    assert!(client.read(0x2051) & 0xff < 100, "it is under way");
    // The client falls silent, so bench mode ends.
    client.attends = false;
    assert_eq!(client.end(), ENDED, "after bench mode");
    // The client withdraws its request.
    client.attends = true;
    for _ in 0..40 {
        client.send(&[]);
    }
    client.write(0x2001, 1);
    client.write(0x2050, 1);
    client.write(0x2050, 0);
    assert_eq!(client.end(), ENDED, "after the request");
}

/// The first excitation shorts the winding, so the back-EMF of a shaft that turns would drive a
/// current above the limit.
#[test]
fn a_calibration_of_a_shaft_that_turns_is_refused_before_any_current_flows() {
    let mut client = Client::new(MOTOR, &[]);
    client.write(0x2001, 1);
    client.write(0x2050, 2);
    while client.speed < 5.0 {
        client.send(&[]);
    }
    client.write(0x2050, 0);
    let (before, begun) = (client.speed, client.steps);
    client.write(0x2050, 2);
    assert_eq!(client.end(), (101, 2), "refused for the speed at the start");
    let [got, bound] = [client.read(0x2053), client.read(0x2054)].map(|value| value / 1_000_000);
    assert!((100..300).contains(&got) && bound == 10, "{got} {bound}");
    assert_eq!(client.read(0x603f) & 0xffff, 0, "no fault");
    // Friction alone has slowed it: 1 N m, 0.25 kg m^2. A shorted winding would stop it at once.
    let slowed = 4.1e-3 * (client.steps - begun) as f32;
    assert!(client.speed > before - slowed && client.speed > 3.0);
}

/// Requests of a client: object, sub-index, and the number of values to choose from.
const REQUESTS: [(u16, u8, usize); 10] = [
    (0x2001, 0, 2), // bench mode
    (0x2050, 0, 4), // calibration
    (0x2050, 0, 4),
    (0x2065, 0, 2), // search for the cogging torque
    (0x2065, 0, 2),
    (0x2060, 1, 3), // recording
    (0x6060, 0, 12),
    (0x6098, 0, 40),
    (0x6040, 0, 16),
    (0x605d, 0, 3), // what a halt does
];

fn write_byte(index: u16, sub: u8, value: u8) -> (u16, Vec<u8>) {
    let [low, high] = index.to_le_bytes();
    (0x600 + NODE, vec![0x2f, low, high, sub, value, 0, 0, 0])
}

fn set_point(word: u16, mode: u8, target: i32) -> (u16, Vec<u8>) {
    let [low, high] = word.to_le_bytes();
    let mut payload = vec![low, high, mode];
    payload.extend(target.to_le_bytes());
    (0x300 + NODE, payload)
}

/// Requests come in any order, two of them within a millisecond, and the client is silent at times.
#[test]
fn no_order_of_requests_turns_a_shaft_too_fast_or_keeps_it_in_motion() {
    let three_phase = MotorModel {
        winding: WindingModel::ThreePhase(WINDING),
        ..MOTOR
    };
    let matching = [
        (Setting::MotorKind, 1),
        (Setting::PolePairs, 7),
        (Setting::ElectricalOffset, 71_000),
        (Setting::TorqueConstant, 63_000),
        (Setting::Inductance, 400),
        (Setting::InductanceQ, 500),
        (Setting::CoggingPeriods, 6),
        (Setting::ScrewLead, 5_000),
    ];
    let brushed = [(Setting::ScrewLead, 5_000)];
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = |count: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 33) as usize % count
    };
    let (mut turning, mut fast) = (0, 0);
    for (role, motor, changes) in [
        ("axle", MOTOR, &brushed[..]),
        ("axle", three_phase, &matching),
        ("screw", MOTOR, &brushed),
        ("screw", three_phase, &matching),
    ] {
        let mut client = Client::of(role, motor, changes);
        client.attends = false;
        for _ in 0..60 {
            client.send(&[(0x000, &[1, NODE as u8])]);
            // The one fault of this drive is the silence of its client.
            let fault = client.read(0x603f) & 0xffff;
            assert!(matches!(fault, 0 | 0x8250), "{role}: fault {fault:#x}");
            client.command(0x80, 0);
            client.command(0, 0);
            client.write(0x2001, 1);
            // The client keeps to this for a while: it calibrates, drives, or leaves the drive off.
            let calibrates = random(3) == 0;
            if calibrates {
                client.write(0x2050, 2);
            }
            let armed = !calibrates && random(4) > 0;
            let mode = [3, 9, 9, 9, 10, 8, 1, 6][random(8)];
            let target = random(2_000_000) as i32 - 1_000_000;
            let silent = random(8) == 0;
            let steps = 100 + random(if calibrates { 12_000 } else { 3_000 });
            for step in 0..steps {
                let mut frames = Vec::new();
                if step % 10 == 0 && !(silent && step > steps / 2) {
                    let word = match step / 10 {
                        _ if !armed => 0,
                        0 => 0x06,
                        1 => 0x07,
                        _ => 0x0f,
                    };
                    frames.push(set_point(word, mode, target));
                }
                // One request comes soon after the drive is armed.
                if random(if armed && step == 60 { 1 } else { 1_000 }) == 0 {
                    for _ in 0..=random(2) {
                        let (index, sub, values) = REQUESTS[random(REQUESTS.len())];
                        frames.push(write_byte(index, sub, random(values) as u8));
                    }
                }
                match random(4_000) {
                    0 => frames.push((0x000, vec![[2, 128, 129, 130][random(4)], 0])),
                    1 => frames.push(set_point([0x02, 0x10f, 0x1f][random(3)], mode, target)),
                    _ => {}
                }
                let frames: Vec<_> = frames.iter().map(|(id, data)| (*id, &data[..])).collect();
                client.send(&frames);
                let speed = client.speed.abs();
                // A calibration is refused above 1.3 times 6 rad/s. Bench mode allows 1 rad/s.
                assert!(speed < 7.8, "{role}: {speed} rad/s");
                turning += usize::from(speed > 0.01);
                fast += usize::from(speed > 1.2);
            }
        }
        client.send(&[(0x000, &[1, 0])]);
        client.write(0x2001, 0);
        // Friction stops a shaft from 6 rad/s in 1.5 s.
        for _ in 0..2_000 {
            client.send(&[]);
        }
        let before = client.read(0x6064);
        for _ in 0..500 {
            client.send(&[]);
        }
        assert!(client.speed.abs() < 1e-3, "{role}: {} rad/s", client.speed);
        // A drive whose client fell silent holds its shaft; a unit is 0.1 mrad.
        let moved = client.read(0x6064) - before;
        assert!(moved.abs() <= 2, "{role}: {moved}");
        let status = client.read(0x6041);
        assert_ne!(status & 0x6f, 0x27, "{role} is in operation: {status:#x}");
        assert!(client.node.finish(), "{role}");
    }
    println!("{turning} ms in motion, {fast} ms faster than 1.2 rad/s");
    assert!(turning > 20_000 && fast > 2_000, "{turning} {fast}");
}
