//! Counts the ticks of a robot's guard: every kind of tick of an armed guard, with a busy bus and a
//! GNSS receiver.

use super::counter::{Table, instructions};
use super::inputs::{Random, settings};
use super::traffic::{BYTES, FRAMES, others, receiver};
use heapless::Vec;
use tautrack::bus::cia402::{State, status};
use tautrack::bus::pdo::{DriveMotion, DriveStatus, OperatorCommand, Payload, Request, transmit};
use tautrack::can::Frame;
use tautrack::node::guard::{self, Guard};
use tautrack::robots::Body;
use tautrack::robots::body::MAX_DRIVES;
use tautrack::sensors::BodySensors;
use tautrack::settings::Setting;

/// Ticks before counting starts, in which the robot is armed.
const WARM_UP: u32 = 4_000;
/// Counted ticks.
const TICKS: u32 = 2_000;
/// Ticks between two heartbeats of a drive, and the maximum number of the drives' answers to a
/// SYNC.
const HEARTBEAT_TICKS: u32 = 48;
const ANSWERS: usize = 2 * MAX_DRIVES + 3;

/// Motion of drives that stand.
pub fn still(_: usize, tick: u32) -> DriveMotion {
    at((tick & 0xff) as i32)
}

/// Motion of a drive at `position`.
pub fn at(position: i32) -> DriveMotion {
    DriveMotion {
        position,
        velocity: 1_000,
    }
}

/// Counts the ticks of a guard that sends SYNC every `sync_ticks` ticks, of a robot that tilts by
/// at most `tilt` rad. `motion` returns the motion of a drive at a tick.
pub fn count_guard<B: Body>(
    table: &mut Table,
    name: &str,
    sync_ticks: u32,
    tilt: f32,
    motion: impl Fn(usize, u32) -> DriveMotion,
) -> Option<()> {
    // With these margins all robots can be armed.
    let settings = settings(&[
        (Setting::SyncPeriod, sync_ticks as i32 * 1_000),
        (Setting::CautionMargin, 16_000),
        (Setting::StopMargin, 6_000),
        (Setting::TripMargin, 2_000),
    ])?;
    let ids = B::drive_ids(&settings);
    let mut guard = Guard::<B>::new(&settings).ok()?;
    let (mut random, mut receiver, mut others) = (Random::new(), receiver(), others(&ids));
    let mut received = scales::<B>(&ids);
    let mut armed = true;
    let counts = (0..WARM_UP + TICKS).map(|tick| {
        let phase = tick % sync_ticks;
        if phase == 0 && tick > 0 {
            received = answers(&ids, tick, sync_ticks, &motion);
        }
        // The drives answer a SYNC in the ticks after it, as fast as the bus carries their frames.
        let chunk = phase.checked_sub(1);
        let answers = chunk.and_then(|chunk| received.chunks(FRAMES).nth(chunk as usize));
        let answers = answers.unwrap_or_default().iter().copied();
        let frames: Vec<Frame, FRAMES> = answers.chain(&mut others).take(FRAMES).collect();
        let serial: Vec<u8, BYTES> = receiver.by_ref().take(BYTES).collect();
        let inputs = guard::Inputs {
            now_us: u64::from(tick) * 1_000,
            body: Some(body(tilt, &mut random)),
            operator: (tick % 20 == 3).then(|| operator(tick, &mut random)),
            emergency_stop: false,
            frames: &frames,
            serial: &serial,
        };
        let count = instructions(&mut (&mut guard, inputs), |(guard, inputs)| {
            guard.tick(inputs);
        });
        armed &= tick < WARM_UP || guard.outputs().state.state == guard::State::Armed.code();
        count
    });
    table.write(name, counts.skip(WARM_UP as usize))?;
    armed.then_some(())
}

/// Returns the answers of the drives to the guard's query for their position scales.
fn scales<B: Body>(ids: &[u8]) -> Vec<Frame, ANSWERS> {
    let [low, high] = guard::POSITION_SCALE.to_le_bytes();
    let answer = |(drive, id): (usize, &u8)| {
        let [a, b] = B::scale(drive).code().to_le_bytes();
        Frame::new(0x580 + u16::from(*id), &[0x4b, low, high, 0, a, b, 0, 0])
    };
    ids.iter().enumerate().filter_map(answer).collect()
}

/// Returns the frames of the drives in answer to a SYNC: position and status of each drive, and
/// heartbeats. They are off until the robot is armed, then enabled.
fn answers(
    ids: &[u8],
    tick: u32,
    sync_ticks: u32,
    motion: impl Fn(usize, u32) -> DriveMotion,
) -> Vec<Frame, ANSWERS> {
    let state = if tick < 160 {
        State::SwitchOnDisabled
    } else {
        State::OperationEnabled
    };
    let status = DriveStatus {
        statusword: state.statusword() | status::HOMED,
        ..DriveStatus::default()
    };
    let syncs = HEARTBEAT_TICKS / sync_ticks;
    let due = ids.iter().skip((tick / sync_ticks % syncs) as usize);
    let heartbeats = due
        .step_by(syncs as usize)
        .filter_map(|id| Frame::new(0x700 + u16::from(*id), &[5]));
    ids.iter()
        .enumerate()
        .flat_map(|(drive, &id)| {
            [
                motion(drive, tick).frame(transmit(1), id),
                status.frame(transmit(2), id),
            ]
        })
        .chain(heartbeats)
        .collect()
}

fn operator(tick: u32, random: &mut Random) -> OperatorCommand {
    OperatorCommand {
        forward: (random.bits() >> 24) as i16,
        yaw_rate: (random.bits() >> 26) as i16,
        posture: (tick / 500 % 2 * 100) as i16,
        // Arming needs a stop before it.
        request: if tick < 100 {
            Request::Stop
        } else {
            Request::Arm
        } as u8,
        sequence: (tick / 20) as u8,
    }
}

fn body(tilt: f32, random: &mut Random) -> BodySensors {
    BodySensors {
        inclination: random.near([0.0; 2], tilt),
        specific_force: random.near([0.0, 0.0, 9.81], 0.5),
        angular_rate: random.near([0.0; 3], 0.2),
        magnetic_field: random.near([0.0, 0.0, -42.0], 20.0),
        ..BodySensors::default()
    }
}
