//! Tests the guarantees of the boards without hardware.

mod node;

use node::{MOTOR, Node, ROLES, elf, settings};
use object::read::elf::ElfFile32;
use object::{Object, ObjectSection, ObjectSegment};
use std::time::Instant;
use tautrack::can::Frame;
use tautrack::link::{BodyMeasurands, Sensors, Stepped};
use tautrack::settings::Setting;

const NODE: u16 = 5;
const STEPS: u32 = 2_000;

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(id, data).expect("a CAN frame")
}

/// Returns the frames on the bus in step `step`: NMT start, SYNC, set-points, and a client's reads
/// and writes of objects.
fn script(step: u32) -> Vec<Frame> {
    let mut frames = Vec::new();
    if step == 5 {
        frames.push(frame(0x000, &[1, 0]));
    }
    if step.is_multiple_of(50) {
        frames.push(frame(0x701, &[5])); // the guard's heartbeat
    }
    if step.is_multiple_of(4) {
        frames.push(frame(0x080, &[]));
        let control = [0x06, 0x07, 0x0f][(step / 40).min(2) as usize];
        let [a, b, c, d] = (step as i32 * 30).to_le_bytes();
        frames.push(frame(0x200 + NODE, &[control, 0, 8, a, b, c, d]));
    }
    match step % 50 {
        10 => frames.push(frame(0x600 + NODE, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0])),
        20 => frames.push(frame(0x600 + NODE, &[0x40, 0x64, 0x60, 0, 0, 0, 0, 0])),
        30 => frames.push(frame(0x600 + NODE, &[0xa0, 0x08, 0x10, 0, 20, 0, 0, 0])),
        45 => frames.push(frame(
            0x600 + NODE,
            // Reads the guard's coordinates q1 to q8 in turn.
            &[0x40, 0x10, 0x40, (step / 50 % 8) as u8 + 1, 0, 0, 0, 0],
        )),
        40 => frames.push(frame(
            0x600 + NODE,
            &[0x2b, 0x7a, 0x60, 0, (step % 200) as u8, 0, 0, 0],
        )),
        _ => {}
    }
    frames
}

fn sensors(step: u32) -> Sensors {
    let wave = (step % 400) as f32 / 200.0 - 1.0;
    Sensors {
        shaft_torque: 8.0 * wave,
        supply_voltage: 24.0 - wave,
        body: Some(BodyMeasurands {
            tilt_force: [wave, 0.0, 9.81],
            specific_force: [0.0, 0.0, 9.81],
            magnetic_field: [20.0 - 5.0 * wave, 7.0 * wave, -42.0],
            ..Default::default()
        }),
        ..Default::default()
    }
}

/// Returns an NMEA sentence of a GNSS receiver that moves north-west.
fn fix(step: u32) -> Vec<u8> {
    let away = step / 200;
    let body = format!(
        "GPGGA,1200{:02}.{}0,4728.704{away:02},N,00033.792{away:02},W,1,08,1.1,40.{away},M,48.0,M,,",
        step / 1_000,
        step % 1_000 / 100
    );
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n").into_bytes()
}

/// Runs the script; returns the answers without their log bytes.
fn run(role: &str, mut node: Node) -> Vec<Stepped> {
    let board = node.board();
    assert_eq!(node.start(&settings(i32::from(NODE)), Some(MOTOR)), "");
    let begin = Instant::now();
    let answers = (0..STEPS)
        .map(|step| {
            if step.is_multiple_of(200) {
                node.say(&fix(step));
            }
            Stepped {
                log: heapless::Vec::new(),
                ..node.step(sensors(step), &script(step))
            }
        })
        .collect();
    let seconds = begin.elapsed().as_secs_f64();
    println!(
        "{role} on {board}: {:.0} steps a second",
        f64::from(STEPS) / seconds
    );
    assert!(
        node.finish(),
        "the node ends well when the simulator is gone"
    );
    answers
}

#[test]
fn emulated_nodes_and_those_in_this_process_answer_alike_to_the_bit() {
    for role in ROLES {
        let host = run(role, Node::host(role));
        let emulated = run(role, Node::emulated(role));
        for (step, (host, emulated)) in host.iter().zip(&emulated).enumerate() {
            assert_eq!(
                host.shaft.velocity.to_bits(),
                emulated.shaft.velocity.to_bits(),
                "{role}, step {step}"
            );
            assert_eq!(host, emulated, "{role}, step {step}");
        }
        assert!(
            host.iter().any(|answer| !answer.frames.is_empty()),
            "{role} says nothing"
        );
    }
}

#[test]
fn the_program_loads_where_the_emulated_board_has_memory() {
    let bytes = std::fs::read(elf()).expect("the program was built");
    let file = ElfFile32::<object::Endianness>::parse(&*bytes).expect("an ELF file");
    let vectors = file
        .section_by_name(".vector_table")
        .expect("a vector table");
    assert_eq!(vectors.address(), 0);
    for segment in file.segments() {
        let address = segment.address();
        assert!(
            address < 0x40_0000 || (0x2000_0000..0x2040_0000).contains(&address),
            "it has a segment at {address:#x}: was it linked with another board's memory?"
        );
    }
}

#[test]
fn unusable_settings_are_refused_with_the_reason() {
    for role in ROLES {
        // A node that has refused its settings has ended.
        for start in [Node::host, Node::emulated] {
            let refusal = start(role).start(&[(1, 128)], Some(MOTOR));
            assert!(refusal.contains("128"), "{refusal}");
            if role == "guard" {
                continue;
            }
            // At 120 % of 12 rad/s, the default motor has 34.6 V.
            let fast = [(1, 4), (Setting::VelocityLimit.description().key, 12_000)];
            let refusal = start(role).start(&fast, Some(MOTOR));
            assert!(
                refusal.starts_with("velocity_limit:") && refusal.contains("38.0 V"),
                "{refusal}"
            );
        }
    }
}
