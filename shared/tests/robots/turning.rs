//! Tests the yaw that the bodies and the guard pass on: it stays within the belts' speed limit, an
//! acceleration, and what the margins allow.

use tautrack::bus::cia402::{State as DriveState, status};
use tautrack::bus::pdo::{
    DriveMotion, DriveStatus, OperatorCommand, Payload, Request, VelocitySetPoint, receive,
    transmit,
};
use tautrack::bus::scale::Scale;
use tautrack::can::Frame;
use tautrack::estimate::attitude::Attitude;
use tautrack::node::guard::{Guard, Inputs, POSITION_SCALE, State};
use tautrack::robots::b2p2::B2p2;
use tautrack::robots::crawler::Crawler;
use tautrack::robots::hylos::{Clearance, Hylos};
use tautrack::robots::rt_mover::RtMover;
use tautrack::robots::{
    Allowed, Body, Command, DriveState as DriveOnBus, Goal, Phase, PostureCommand,
};
use tautrack::sensors::BodySensors;
use tautrack::settings::{Setting, Settings};
use tautrack::stability::limits::MotionLimits;

const PERIOD: f32 = 4e-3;
const SPEED_LIMIT: f32 = 0.45;
const ACCELERATION: f32 = 0.4;

fn settings(changes: &[(Setting, i32)]) -> Settings {
    let mut settings = Settings::default();
    for (setting, value) in changes {
        settings
            .set(setting.description().key, *value)
            .expect("a value within bounds");
    }
    settings
}

/// Permission without restrictions, as far away from every edge.
fn free() -> Allowed {
    Allowed {
        speed_scale: 1.0,
        stop: None,
        brakes: false,
        posture: true,
        limits: MotionLimits {
            forward: 1.5,
            backward: 1.5,
            left: 100.0,
            right: 100.0,
            posture: 1.0,
        },
    }
}

fn speed_of<B: Body>(body: &B, drive: usize, radius: f32) -> f32 {
    match body.goal(Phase::Armed, drive) {
        Goal::Velocity(rate) => rate * radius,
        goal => panic!("drive {drive} has the goal {goal:?}"),
    }
}

/// Runs several commands for some seconds, the largest first. Checks that no belt is faster than
/// the speed limit, or changes its speed faster than `acceleration`, m/s^2.
fn assert_within_the_belts<B: Body>(settings: &Settings, radius: f32, acceleration: f32) {
    let mut body = B::new(settings).unwrap_or_else(|refusal| panic!("{refusal:?}"));
    let mut attitude = Attitude::default();
    body.rest();
    let mut before = [0.0_f32; 2];
    let mut turns = [0.0_f64; 2];
    let (mut fastest, mut quickest) = (0.0_f32, 0.0_f32);
    for step in 0..6_000 {
        let asked = [
            (0.0, 32.767),
            (0.0, -32.767),
            (0.45, 0.0),
            (-0.3, 2.0),
            (1.0, 32.767),
            (0.1, -0.3),
        ][step / 1_000];
        let asked = Command {
            forward: asked.0,
            yaw_rate: asked.1,
            posture: B::Posture::from_word(0),
        };
        // The belts follow their set-points, and the robot moves with them.
        let drives = turns.map(|turns| DriveOnBus {
            position: Scale::Turning { bits: 16 }
                .units()
                .position((turns * 65_536.0) as i64 as i32),
            ..DriveOnBus::default()
        });
        let reading = BodySensors {
            angular_rate: [0.0, 0.0, (before[1] - before[0]) / 0.32],
            ..BodySensors::default()
        };
        assert!(attitude.update(&reading, PERIOD));
        body.observe(&drives, &attitude, PERIOD);
        body.advance(&asked, free(), &attitude, PERIOD);
        for (side, before) in before.iter_mut().enumerate() {
            let speed = speed_of(&body, side, radius);
            fastest = fastest.max(speed.abs());
            quickest = quickest.max((speed - *before).abs() / PERIOD);
            *before = speed;
            turns[side] += f64::from(speed * PERIOD / radius) / std::f64::consts::TAU;
        }
    }
    assert!(fastest <= SPEED_LIMIT + 1e-5, "{fastest} m/s");
    assert!(fastest > 0.99 * SPEED_LIMIT, "{fastest} m/s");
    // Tolerance: a micrometre per second in one period is 0.25 mm/s^2.
    assert!(quickest <= acceleration + 1e-3, "{quickest} m/s^2");
}

#[test]
fn no_command_drives_a_belt_of_b2p2_beyond_speed_limit_and_acceleration() {
    // Forward speed and yaw each have an acceleration limit of their own.
    assert_within_the_belts::<B2p2>(&Settings::default(), 0.05, 2.0 * ACCELERATION);
}

#[test]
fn no_command_drives_a_belt_of_the_crawler_beyond_speed_limit_and_acceleration() {
    let settings = settings(&[
        (Setting::VelocityLimit, 1_000_000),
        (Setting::SlipCompensation, 0),
    ]);
    // The correction of the path adds to those of forward speed and yaw.
    assert_within_the_belts::<Crawler>(&settings, 0.05, 3.0 * ACCELERATION);
}

#[test]
fn no_command_spins_hylos_beyond_its_speed_limit_or_at_once() {
    let mut body = Hylos::new(&Settings::default()).expect("the nominal robot");
    let attitude = Attitude::default();
    body.rest();
    let mut fastest = 0.0_f32;
    for step in 0..2_000 {
        let asked = Command {
            yaw_rate: 32.767,
            forward: 0.0,
            posture: Clearance::default(),
        };
        body.advance(&asked, free(), &attitude, PERIOD);
        // Drive 3 of each leg is its wheel.
        for leg in 0..4 {
            fastest = fastest.max(speed_of(&body, 4 * leg + 3, 0.1).abs());
        }
        // The bound has room for the radius of 0.1 m, which is above the wheel's, and for the
        // distance of the wheels beyond the hips.
        assert!(fastest <= 0.02 + 0.01 * step as f32, "{step}: {fastest}");
    }
    assert!(fastest <= 2.0 * SPEED_LIMIT, "{fastest}");
}

/// Robot after 3 s of a command of which the guard passes a quarter.
fn at_a_quarter<B: Body>(settings: &Settings, forward: f32, yaw_rate: f32) -> B {
    let mut body = B::new(settings).unwrap_or_else(|refusal| panic!("{refusal:?}"));
    let allowed = Allowed {
        speed_scale: 0.25,
        ..free()
    };
    let asked = Command {
        forward,
        yaw_rate,
        posture: B::Posture::from_word(0),
    };
    body.rest();
    for _ in 0..750 {
        body.advance(&asked, allowed, &Attitude::default(), PERIOD);
    }
    body
}

/// A command beyond what the robot can do must not bypass the scale of the guard.
#[test]
fn a_quarter_of_too_fast_a_command_is_a_quarter_of_the_speed_limit() {
    let settings = Settings::default();
    let quarter = 0.25 * SPEED_LIMIT;
    for (forward, yaw_rate) in [(0.0, 25.0), (0.0, -32.767), (32.767, 0.0), (-1.0, 3.0)] {
        let body = at_a_quarter::<B2p2>(&settings, forward, yaw_rate);
        let belts = [0, 1].map(|side| speed_of(&body, side, 0.05));
        let fastest = belts[0].abs().max(belts[1].abs());
        let off = (fastest - quarter).abs();
        assert!(off < 1e-3, "{forward} m/s, {yaw_rate} rad/s: {belts:?} m/s");
    }
    for speed in [
        at_a_quarter::<Crawler>(&settings, 32.767, 0.0).speed(),
        at_a_quarter::<Hylos>(&settings, 32.767, 0.0).speed(),
        at_a_quarter::<RtMover>(&settings, 32.767, 0.0).speed(),
    ] {
        assert!((speed - quarter).abs() < 1e-3, "{speed} m/s");
    }
}

/// Guard of B2P2 with drives that follow their commands, on level ground.
struct Bench {
    guard: Guard<B2p2>,
    now_us: u64,
    command: OperatorCommand,
    targets: [i32; 2],
}

impl Bench {
    fn armed(settings: &Settings) -> Self {
        let mut bench = Self {
            guard: Guard::new(settings).expect("a good robot"),
            now_us: 0,
            command: OperatorCommand::default(),
            targets: [0; 2],
        };
        bench.run(300);
        bench.command.request = Request::Arm as u8;
        bench.run(1_000);
        let state = bench.guard.outputs().state.state;
        assert_eq!(State::from_code(state), Some(State::Armed));
        bench
    }

    fn run(&mut self, ticks: usize) {
        for _ in 0..ticks {
            self.tick();
        }
    }

    fn tick(&mut self) {
        self.now_us += 1_000;
        self.command.sequence = self.command.sequence.wrapping_add(1);
        let mut frames = Vec::new();
        for id in [2, 3, 4, 5] {
            if self.now_us.is_multiple_of(50_000) {
                frames.extend(Frame::new(0x700 + u16::from(id), &[5]));
            }
            // The screw holds the belt taut.
            let position = if id == 5 {
                (0.226 * 16_777_216.0) as i32
            } else {
                0
            };
            let motion = DriveMotion {
                position,
                velocity: 0,
            };
            // Drives follow at once when the guard enables them, and report their position scale.
            let guard = State::from_code(self.guard.outputs().state.state);
            let state = if guard.is_some_and(State::driving) {
                DriveState::OperationEnabled
            } else {
                DriveState::SwitchOnDisabled
            };
            if self.now_us == 100_000 {
                let [low, high] = POSITION_SCALE.to_le_bytes();
                let [a, b] = B2p2::scale(usize::from(id) - 2).code().to_le_bytes();
                let answer = [0x4b, low, high, 0, a, b, 0, 0];
                frames.extend(Frame::new(0x580 + u16::from(id), &answer));
            }
            let status = DriveStatus {
                statusword: state.statusword() | status::HOMED,
                ..DriveStatus::default()
            };
            if self.now_us.is_multiple_of(4_000) {
                frames.push(motion.frame(transmit(1), id));
                frames.push(status.frame(transmit(2), id));
            }
        }
        // The last digits of every reading are noise.
        let noise = |channel: u64| 1e-6 * ((self.now_us / 1_000 * 7 + channel * 3) % 5) as f32;
        let body = BodySensors {
            inclination: [noise(0), noise(1)],
            specific_force: [noise(2), noise(3), 9.81 + noise(4)],
            angular_rate: [noise(5), noise(6), noise(7)],
            ..BodySensors::default()
        };
        let outputs = self.guard.tick(&Inputs {
            now_us: self.now_us,
            body: Some(body),
            operator: Some(self.command),
            emergency_stop: false,
            frames: &frames,
            serial: &[],
        });
        for (target, id) in self.targets.iter_mut().zip([2, 3]) {
            for frame in &outputs.frames {
                if let Some(point) = VelocitySetPoint::from_frame(frame, receive(2), id) {
                    *target = point.target;
                }
            }
        }
    }

    /// Forward speed, m/s, and yaw rate, rad/s, of the set-points of the tracks.
    fn motion(&self) -> [f64; 2] {
        let [left, right] = self.targets.map(|target| f64::from(target) * 1e-6 * 0.05);
        [0.5 * (left + right), (right - left) / 0.32]
    }
}

/// Commands 32.767 rad/s on the spot. Without the limits, the sprockets would turn at 104.9 rad/s
/// within 5 ms.
#[test]
fn the_guard_ramps_a_spin_and_keeps_it_within_the_speed_limit() {
    let mut bench = Bench::armed(&Settings::default());
    bench.command.yaw_rate = i16::MAX;
    bench.run(100);
    let [_, slow] = bench.motion();
    // The limit is 2.5 rad/s^2.
    assert!(slow > 0.1 && slow < 0.3, "{slow} rad/s after 0.1 s");
    bench.run(3_000);
    let [forward, fast] = bench.motion();
    assert!(
        forward.abs() < 1e-3 && (fast - 0.45 / 0.16).abs() < 0.02,
        "{fast} rad/s"
    );
}

/// On a curve the centripetal acceleration stays within what the margins to the sides allow: at
/// most the configured 0.4 m/s^2.
#[test]
fn the_guard_limits_yaw_by_the_margins_to_the_sides() {
    let mut bench = Bench::armed(&settings(&[(Setting::SpeedLimit, 2_000_000)]));
    bench.command.forward = 600;
    bench.run(3_000);
    bench.command.yaw_rate = 1_500;
    for _ in 0..3_000 {
        bench.tick();
        let [forward, yaw_rate] = bench.motion();
        assert!(
            (forward * yaw_rate).abs() < 0.41,
            "{forward} m/s, {yaw_rate} rad/s"
        );
    }
    let [forward, yaw_rate] = bench.motion();
    assert!(
        forward > 0.5 && yaw_rate > 0.5,
        "{forward} m/s, {yaw_rate} rad/s"
    );
}
