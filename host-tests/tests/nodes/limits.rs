//! Tests with commands, readings and frames of any content: the frames that the guard sends stay
//! within the limits of its settings.

use crate::network::{Network, level};
use crate::random::Random;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use tautrack::bus::cia402::{controlword, mode};
use tautrack::bus::network::is_sync;
use tautrack::bus::pdo::{Payload, PositionSetPoint, Request, VelocitySetPoint, receive};
use tautrack::can::Frame;
use tautrack::node::guard::State;
use tautrack::robots::b2p2::B2p2;
use tautrack::sensors::BodySensors;
use tautrack::settings::{Setting, Settings};

const TRACKS: [u8; 2] = [2, 3];
const JOINT: u8 = 4;

/// Limits of B2P2, computed from the settings alone, and what the guard's frames contained.
struct Limits {
    /// Speed of a pulley, rad/s.
    track: f64,
    /// Travel of the joint in one SYNC period, 2^-32 turn.
    joint_step: f64,
    joint_before: Option<i32>,
    /// Number of SYNC periods in each state.
    states: BTreeMap<&'static str, u32>,
    fastest: f64,
}

impl Limits {
    fn new(settings: &Settings) -> Self {
        let micro = |setting| f64::from(settings.get(setting)) * 1e-6;
        let joint_speed = f64::from(settings.get(Setting::ChassisSpeed)) * 1e-3;
        let period = micro(Setting::SyncPeriod);
        Self {
            track: micro(Setting::SpeedLimit) / micro(Setting::PulleyRadius),
            joint_step: joint_speed * period / (2.0 * PI) * 2.0_f64.powi(32),
            joint_before: None,
            states: BTreeMap::new(),
            fastest: 0.0,
        }
    }

    fn check(&mut self, state: State, sent: &[Frame], events: &[String]) {
        if !sent.iter().any(is_sync) {
            return;
        }
        *self.states.entry(state.name(&[])).or_default() += 1;
        for frame in sent {
            for id in TRACKS {
                if let Some(point) = VelocitySetPoint::from_frame(frame, receive(2), id) {
                    self.check_track(state, point, events);
                }
            }
            if let Some(point) = PositionSetPoint::from_frame(frame, receive(1), JOINT) {
                self.check_joint(state, point, events);
            }
        }
    }

    fn check_track(&mut self, state: State, point: VelocitySetPoint, events: &[String]) {
        let speed = f64::from(point.target).abs() * 1e-6 / self.track;
        assert!(speed <= 1.000_1, "{speed} of the limit; {events:#?}");
        self.fastest = self.fastest.max(speed);
        let enables = point.controlword == controlword::ENABLE_OPERATION;
        assert!(
            state == State::Armed || !enables || point.target == 0,
            "{point:?} in {state:?}; {events:#?}"
        );
    }

    fn check_joint(&mut self, state: State, point: PositionSetPoint, events: &[String]) {
        let follows = state == State::Armed && point.mode == mode::CYCLIC_POSITION;
        if let (true, Some(before)) = (follows, self.joint_before) {
            let step = f64::from(point.target.wrapping_sub(before)).abs() / self.joint_step;
            assert!(step <= 1.001, "{step} of the limit; {events:#?}");
        }
        self.joint_before = follows.then_some(point.target);
    }
}

/// Random reading: level ground, a tilt, or any bits.
fn reading(random: &mut Random) -> BodySensors {
    match random.below(8) {
        0..=3 => level(),
        4..=6 => {
            let pitch = random.between(-700, 700) as f32 * 1e-3;
            let gravity = level().specific_force[2];
            BodySensors {
                inclination: [pitch, 0.0],
                specific_force: [-gravity * pitch.sin(), 0.0, gravity * pitch.cos()],
                ..level()
            }
        }
        _ => {
            let mut any = || f32::from_bits(random.bits() as u32);
            BodySensors {
                inclination: [any(), any()],
                specific_force: [any(), any(), any()],
                angular_rate: [any(), any(), any()],
                magnetic_field: [any(), any(), any()],
                ..level()
            }
        }
    }
}

/// Random request; most of them let the robot drive.
fn request(random: &mut Random) -> Request {
    match random.below(12) {
        0..=5 => Request::Arm,
        6 => Request::Override,
        7 => Request::BackOff,
        8 | 9 => Request::Reset,
        10 => Request::Stop,
        _ => [Request::Disarm, Request::EmergencyStop][random.below(2) as usize],
    }
}

fn frame(random: &mut Random) -> Option<Frame> {
    let data = random.bits().to_le_bytes();
    let length = random.below(9) as usize;
    Frame::new(random.below(0x800) as u16, &data[..length])
}

#[test]
fn no_command_reading_or_frame_gets_a_set_point_beyond_its_limit() {
    let mut total: BTreeMap<&'static str, u32> = BTreeMap::new();
    let mut fastest = 0.0_f64;
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let mut network = Network::<B2p2>::new("staircase.toml", &[]);
        let mut limits = Limits::new(&network.guard_settings);
        let mut events = vec![format!("seed {seed}")];
        for _ in 0..60 {
            let request = request(&mut random);
            network.request(request);
            let any = random.bits();
            network.command.forward = any as i16;
            network.command.yaw_rate = (any >> 16) as i16 >> random.below(16);
            network.command.posture = (any >> 32) as i16;
            network.body = reading(&mut random);
            // A foreign frame may put the robot into the state "held", which most sequences would
            // not leave again.
            if random.below(16) == 0 {
                network.foreign.extend(frame(&mut random));
            }
            let milliseconds = random.between(1, 1_500);
            events.push(format!(
                "{:?}, {:?}, {:?} for {milliseconds} ms",
                network.command, network.body, network.foreign
            ));
            for _ in 0..milliseconds {
                network.tick();
                let sent = std::mem::take(&mut network.sent);
                limits.check(network.state(), &sent, &events);
            }
        }
        for (state, periods) in limits.states {
            *total.entry(state).or_default() += periods;
        }
        fastest = fastest.max(limits.fastest);
    }
    println!("{total:?}, {fastest} of the limit");
    for state in ["ready", "starting", "armed", "held"] {
        assert!(total.get(state).is_some_and(|n| *n > 500), "{total:?}");
    }
    assert!(fastest > 0.99, "{fastest}");
}
