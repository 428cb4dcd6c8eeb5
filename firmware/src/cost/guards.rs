//! Counts the guard ticks of the crawler, RT-Mover and Hylos, with all kinds of tick in one count,
//! and one moment of the prediction that RT-Mover's guard computes before it steps up.

use super::counter::{Count, Table, instructions};
use super::inputs::Random;
use super::traffic::{FRAMES, Source, Traffic};
use core::f32::consts::TAU;
use core::hint::black_box;
use heapless::Vec;
use tautrack::bus::cia402::{State, status};
use tautrack::bus::pdo::{DriveMotion, DriveStatus, OperatorCommand, Payload, Request, transmit};
use tautrack::can::Frame;
use tautrack::constants::CONTROL_PERIOD;
use tautrack::node::guard::{self, Guard};
use tautrack::robots::Body;
use tautrack::robots::body::MAX_DRIVES;
use tautrack::robots::crawler::Crawler;
use tautrack::robots::hylos::controller::stance;
use tautrack::robots::hylos::{self, Hylos};
use tautrack::robots::rt_mover::parameters::Parameters;
use tautrack::robots::rt_mover::prediction::{Prediction, Progress, Way};
use tautrack::robots::rt_mover::wheel::WHEELS;
use tautrack::robots::rt_mover::{RtMover, Shape};
use tautrack::sensors::BodySensors;
use tautrack::settings::{Setting, Settings};

/// Ticks before counting starts, in which the robot is armed.
const WARM_UP: u32 = 2_000;

/// Margin levels with which all three robots can be armed.
const LEVELS: [(Setting, i32); 3] = [
    (Setting::CautionMargin, 16_000),
    (Setting::StopMargin, 6_000),
    (Setting::TripMargin, 2_000),
];

pub fn count(table: &mut Table) {
    let [hip, knee] = stance(&hylos::Parameters::<f32>::nominal(), 0.29);
    // Each leg of Hylos has four motors: hip, knee, steering, wheel.
    let leg = |drive: usize| [hip, knee, 0.0, 0.0][drive & 3];
    let quiet = Traffic::Quiet;
    count_guard::<Crawler>(table, "guard tick of the crawler", quiet, 4, |_| 0.0);
    count_guard::<RtMover>(table, "guard tick of RT-Mover", quiet, 5, |_| 0.0);
    count_guard::<Hylos>(table, "guard tick of Hylos", quiet, 8, leg);
    let busy = Traffic::Busy;
    count_guard::<Crawler>(table, "guard tick of the crawler, busy", busy, 4, |_| 0.0);
    count_guard::<RtMover>(table, "guard tick of RT-Mover, busy", busy, 5, |_| 0.0);
    count_guard::<Hylos>(table, "guard tick of Hylos, busy", busy, 8, leg);
    count_prediction(table);
}

/// Returns the operator's request: first a stop, then to arm.
pub fn request(tick: u32) -> Request {
    if tick < 100 {
        Request::Stop
    } else {
        Request::Arm
    }
}

/// Returns the state of the drives: off until the robot is armed, then enabled.
pub fn drive_state(tick: u32) -> State {
    if tick < 140 {
        State::SwitchOnDisabled
    } else {
        State::OperationEnabled
    }
}

/// Answers the guard's query for the position scale of every drive.
pub fn answer_scales<B: Body>(guard: &mut Guard<B>, settings: &Settings) {
    let [low, high] = guard::POSITION_SCALE.to_le_bytes();
    let mut frames = Vec::<Frame, MAX_DRIVES>::new();
    for (drive, id) in B::drive_ids(settings).into_iter().enumerate() {
        let [a, b] = B::scale(drive).code().to_le_bytes();
        let answer = [0x4b, low, high, 0, a, b, 0, 0];
        // Drives beyond the capacity of `frames` do not answer.
        let _ = frames.push(Frame::new(0x580 + u16::from(id), &answer).unwrap_or_default());
    }
    guard.tick(&guard::Inputs {
        now_us: 0,
        body: None,
        operator: None,
        emergency_stop: false,
        frames: &frames,
        serial: &[],
    });
}

/// Returns the frames of enabled drives at `angle` (rad) in answer to a SYNC: position and status
/// of each drive, and the heartbeats of two drives in turn.
fn answers(
    ids: &[u8],
    sync: u32,
    state: State,
    angle: impl Fn(usize) -> f32,
) -> Vec<Frame, { 2 * MAX_DRIVES + 2 }> {
    let motion = |drive: usize| DriveMotion {
        position: (angle(drive) * (16_777_216.0 / TAU)) as i32 + (sync & 0xff) as i32,
        velocity: 1_000,
    };
    let status = DriveStatus {
        statusword: state.statusword() | status::HOMED,
        ..DriveStatus::default()
    };
    // With two heartbeats per SYNC period, no heartbeat is older than 64 ms.
    let heartbeats = [0, 1].map(|n| {
        let id = ids[(2 * sync + n) as usize % ids.len()];
        Frame::new(0x700 + u16::from(id), &[5]).unwrap_or_default()
    });
    ids.iter()
        .enumerate()
        .flat_map(|(drive, &id)| {
            [
                motion(drive).frame(transmit(1), id),
                status.frame(transmit(2), id),
            ]
        })
        .chain(heartbeats)
        .collect()
}

fn body(random: &mut Random) -> BodySensors {
    BodySensors {
        inclination: [random.within(0.05), random.within(0.05)],
        specific_force: [random.within(0.5), random.within(0.5), 9.81],
        angular_rate: [random.within(0.2), random.within(0.2), random.within(0.2)],
        magnetic_field: [random.within(20.0), random.within(20.0), -42.0],
        ..BodySensors::default()
    }
}

fn tick_of<B: Body>(guard: &mut Guard<B>, inputs: guard::Inputs<'_>) {
    guard.tick(&inputs);
}

/// Counts every tick of a guard that sends SYNC every `sync_ticks` ticks.
fn count_guard<B: Body>(
    table: &mut Table,
    name: &str,
    traffic: Traffic,
    sync_ticks: u32,
    angle: impl Fn(usize) -> f32,
) {
    let mut settings = Settings::default();
    let period_us = sync_ticks as i32 * (CONTROL_PERIOD * 1e6) as i32;
    for (setting, value) in [(Setting::SyncPeriod, period_us)].into_iter().chain(LEVELS) {
        let _ = settings.set(setting.description().key, value); // cannot fail: within the bounds
    }
    let settings = black_box(settings);
    let ids = B::drive_ids(&settings);
    let Ok(mut guard) = Guard::<B>::new(&settings) else {
        return; // the nominal robot is valid; otherwise the host finds no entry
    };
    answer_scales(&mut guard, &settings);
    let (mut random, mut source) = (Random::new(), Source::new(traffic));
    let (mut count, mut armed) = (Count::NONE, true);
    let mut received = Vec::new();
    for tick in 0..WARM_UP + sync_ticks * table.calls() {
        let phase = tick % sync_ticks;
        if phase == 0 {
            received = answers(&ids, tick / sync_ticks, drive_state(tick), &angle);
        }
        let mut packets = received.chunks(FRAMES);
        let answered = if phase == 0 {
            &[]
        } else {
            packets.nth(phase as usize - 1).unwrap_or_default()
        };
        // Frames of others fill the bus where the drives leave room.
        let others = source.frames(settings.id(Setting::NodeId), &ids);
        let frames: Vec<Frame, FRAMES> = answered
            .iter()
            .chain(&others)
            .take(FRAMES)
            .copied()
            .collect();
        let serial = source.bytes();
        let operator = (tick % 20 == 3).then(|| OperatorCommand {
            forward: (random.bits() >> 24) as i16,
            yaw_rate: (random.bits() >> 26) as i16,
            posture: (tick / 1_000 % 2 * 100) as i16,
            request: request(tick) as u8,
            sequence: tick as u8,
        });
        let inputs = guard::Inputs {
            now_us: u64::from(tick) * 1_000,
            body: Some(body(&mut random)),
            operator,
            emergency_stop: false,
            frames: &frames,
            serial: &serial,
        };
        if tick < WARM_UP {
            tick_of(&mut guard, inputs);
        } else {
            count.take(instructions(&mut guard, inputs, tick_of));
            armed &= guard.outputs().state.state == guard::State::Armed.code();
        }
    }
    // If the robot was not armed all the time, the counts are not those of the named tick. No entry
    // is written then, and the host reports it missing.
    if armed {
        table.write(
            name,
            &count,
            tick_of as fn(&mut Guard<B>, guard::Inputs<'static>) as usize,
        );
    }
}

fn count_prediction(table: &mut Table) {
    struct Mind {
        parameters: Parameters<f32>,
        prediction: Option<Prediction<f32>>,
        over: bool,
    }
    const WAY: Way<f32> = Way {
        rise: 0.2,
        travel: 0.15,
        fall: 0.03,
    };
    let mut mind = Mind {
        parameters: black_box(Parameters::nominal()),
        prediction: None,
        over: true,
    };
    // Runs each prediction from its beginning to its end, then starts another one.
    let question = |mind: &mut Mind, call: u32, random: &mut Random| {
        if !mind.over {
            return;
        }
        let shape = Shape {
            pitch: random.within(0.1),
            steering: [random.within(0.2), random.within(0.5)],
            roll: [random.within(0.2), random.within(0.2)],
        };
        let (heading, wheel) = (random.within(0.2), WHEELS[(call & 3) as usize]);
        let begun = Prediction::new(&mind.parameters, &shape, heading, wheel, &WAY);
        mind.prediction = Some(begun);
    };
    table.kernel(
        "moment of RT-Mover's prediction",
        &mut mind,
        question,
        |mind, ()| {
            if let Some(prediction) = &mut mind.prediction {
                mind.over = prediction.moment(&mind.parameters) != Progress::Unfinished;
            }
        },
    );
}
