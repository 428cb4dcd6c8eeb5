//! Measures the maximum stack of a node's program during a short run on the bus, in which it is
//! started, receives commands and requests, and receives the answers of all other nodes.
//!
//! The result is measured, not proven. It does not include code that this run does not reach, nor
//! interrupts, which the emulated board does not have.

use super::CostError;
use crate::programs::setup::QEMU;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use tautrack::bus::cia402::{State, controlword, status};
use tautrack::bus::network::{NmtCommand, nmt, sync};
use tautrack::bus::pdo::{
    DriveMotion, DriveStatus, OperatorCommand, Payload, PositionSetPoint, Request, receive,
    transmit,
};
use tautrack::can::Frame;
use tautrack::link::{
    BodyMeasurands, MotorModel, Prefix, STEP_US, Sensors, Start, Step, ToNode, VERSION,
    WindingModel,
};
use tautrack::settings::Setting;

/// Steps of the run, 1 ms each.
const STEPS: u64 = 2_000;
/// Id of the measured node, unless it is the guard.
const NODE: u8 = 5;
/// Id of the guard. The drives have the default ids of the settings.
const GUARD: u8 = 1;
/// Position scales that the drives report to the guard: low and high byte.
const SCALES: [(u8, u8); 4] = [(16, 0), (16, 0), (32, 0), (0x18, 1)];
/// Extension of the screw with a taut belt at chassis angle 0, 2^-24 m.
const TAUT: i32 = 3_791_650;

const MOTOR: MotorModel = MotorModel {
    winding: WindingModel::Brushed {
        resistance: 0.6,
        inductance: 3e-4,
        torque_constant: 0.04,
    },
    rotor_inertia: 1e-5,
    gear_ratio: 60.0,
    friction_torque: 0.1,
    brake_torque: 0.0,
    encoder_counts: 4_096,
    current_noise: 0.01,
    current_quantum: 0.01,
    dead_time: 0.0,
};

/// Measures the maximum stack of the node program at `path`, bytes.
///
/// # Errors
/// QEMU does not run, or the program does not report its stack.
pub fn deepest(path: &Path, with_motor: bool) -> Result<u32, CostError> {
    let mut child = Command::new(QEMU)
        .args([
            "-M",
            "mps2-an386",
            "-nographic",
            "-monitor",
            "none",
            "-serial",
            "none",
        ])
        .args(["-semihosting-config", "enable=on,target=native"])
        .arg("-kernel")
        .arg(path)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()?;
    let pipes = child.stdin.take().zip(child.stdout.take());
    let (mut input, mut output) =
        pipes.ok_or_else(|| CostError::Malformed("no pipes".to_owned()))?;
    let start = Start {
        version: VERSION,
        seed: 1,
        flash: heapless::String::new(),
        settings: heapless::Vec::from_iter([(
            Setting::NodeId.description().key,
            i32::from(if with_motor { NODE } else { GUARD }),
        )]),
        motor: with_motor.then_some(MOTOR),
        role: heapless::String::new(),
    };
    let mut exchange = |message: &ToNode| -> Result<(), CostError> {
        let bytes = postcard::to_stdvec(message)
            .map_err(|error| CostError::Malformed(error.to_string()))?;
        let length = bytes.len() as u16;
        input.write_all(&Prefix { length, node: 0 }.to_bytes())?;
        input.write_all(&bytes)?;
        let mut prefix = [0; Prefix::BYTES];
        output.read_exact(&mut prefix)?;
        let mut answer = vec![0; usize::from(Prefix::from_bytes(prefix).length)];
        Ok(output.read_exact(&mut answer)?)
    };
    exchange(&ToNode::Start(start))?;
    for step in 0..STEPS {
        exchange(&ToNode::Step(life(step, !with_motor)))?;
    }
    drop(input);
    let mut last_word = String::new();
    output.read_to_string(&mut last_word)?;
    child.wait()?;
    last_word
        .trim()
        .parse()
        .map_err(|_| CostError::Malformed(format!("not a stack: {last_word:?}")))
}

fn life(step: u64, is_guard: bool) -> Step {
    let mut frames = heapless::Vec::new();
    let mut deliver = |frame: Frame| {
        let _ = frames.push(frame); // there is room for many more
    };
    match step {
        10 => deliver(nmt(NmtCommand::Start, 0)),
        _ if is_guard && step.is_multiple_of(20) => deliver(
            OperatorCommand {
                forward: 200,
                yaw_rate: 100,
                posture: 300,
                request: if step < 200 {
                    Request::Stop
                } else {
                    Request::Arm
                } as u8,
                sequence: step as u8,
            }
            .frame(receive(1), GUARD),
        ),
        40 if is_guard => {
            for (node, (low, high)) in (2..).zip(SCALES) {
                let answer = [0x4b, 0x10, 0x20, 0, low, high, 0, 0];
                deliver(Frame::new(0x580 + node, &answer).unwrap_or_default());
            }
        }
        _ if step % 100 == 50 => {
            let read = [0x40, 0x64, 0x60, 0, 0, 0, 0, 0];
            deliver(Frame::new(0x600 + u16::from(NODE), &read).unwrap_or_default());
        }
        _ => {}
    }
    if step.is_multiple_of(50) && !is_guard {
        deliver(Frame::new(0x701, &[5]).unwrap_or_default()); // the guard's heartbeat
    }
    if step.is_multiple_of(4) && !is_guard {
        let word = match step / 100 {
            0 => controlword::SHUTDOWN,
            1 => controlword::SWITCH_ON,
            _ => controlword::ENABLE_OPERATION,
        };
        let set_point = PositionSetPoint {
            controlword: word,
            mode: [1, 3, 6, 8, 9, -1][(step / 300) as usize % 6],
            target: (step as i32) << 6,
        };
        deliver(set_point.frame(receive(1), NODE));
        deliver(sync());
    }
    if step % 4 == 1 {
        let nodes = if is_guard { 2..6 } else { 1..5 };
        for node in nodes {
            let motion = DriveMotion {
                position: if node == 5 { TAUT } else { 1 << 20 },
                velocity: 0,
            };
            // The drives are enabled after the operator has requested to arm.
            let state = if is_guard && step < 240 {
                State::SwitchOnDisabled
            } else {
                State::OperationEnabled
            };
            let status = DriveStatus {
                statusword: state.statusword() | status::HOMED,
                ..DriveStatus::default()
            };
            deliver(motion.frame(transmit(1), node));
            deliver(status.frame(transmit(2), node));
            deliver(Frame::new(0x700 + u16::from(node), &[5]).unwrap_or_default());
        }
    }
    Step {
        time_us: (step + 1) * STEP_US,
        sensors: Sensors {
            supply_voltage: 24.0,
            body: is_guard.then(|| BodyMeasurands {
                specific_force: [0.0, 0.0, 9.81],
                tilt_force: [0.0, 0.0, 9.81],
                ..BodyMeasurands::default()
            }),
            ..Sensors::default()
        },
        frames,
        serial: heapless::Vec::new(),
    }
}
