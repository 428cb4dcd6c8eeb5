//! The guard's tick against drives that always do as they are told.

use tautrack::bus::network::{Emergency, emergency, sync};
use tautrack::bus::pdo::{
    DriveMotion, DriveStatus, OperatorCommand, Payload, PositionSetPoint, Request,
    VelocitySetPoint, receive, transmit,
};
use tautrack::can::Frame;
use tautrack::faults::Fault;
use tautrack::node::BodySensors;
use tautrack::node::cia402::{State as DriveState, controlword, status};
use tautrack::node::guard::{Guard, Inputs, Outputs, State};
use tautrack::robots::b2p2::B2p2;
use tautrack::settings::Settings;
use tautrack::stability::filter::Verdict;
use tautrack::stability::support::Edge;

const DRIVES: [u8; 4] = [2, 3, 4, 5];
const SCREW: u8 = 5;
/// Extension at chassis angle 0, 2^-24 m.
const TAUT: i32 = (0.226 * 16_777_216.0) as i32;

/// A guard among perfect drives, with an operator and level ground unless a test says otherwise.
struct Bench {
    guard: Guard<B2p2>,
    now_us: u64,
    command: Option<OperatorCommand>,
    body: Option<BodySensors>,
    extra: Vec<Frame>,
    silent: Option<u8>,
    sent: Vec<Frame>,
}

impl Bench {
    fn armed() -> Self {
        let mut bench = Self {
            guard: Guard::new(&Settings::default()).expect("the default robot is good"),
            now_us: 0,
            command: Some(OperatorCommand {
                request: Request::Arm as u8,
                ..OperatorCommand::default()
            }),
            body: Some(standing(0.0)),
            extra: Vec::new(),
            silent: None,
            sent: Vec::new(),
        };
        let outputs = bench.run(1_000);
        assert_eq!(State::from_code(outputs.state.state), Some(State::Armed));
        bench
    }

    fn run(&mut self, ticks: u64) -> Outputs {
        (0..ticks)
            .map(|_| self.tick())
            .last()
            .expect("at least one tick")
    }

    fn tick(&mut self) -> Outputs {
        self.now_us += 1_000;
        let mut frames = std::mem::take(&mut self.extra);
        for id in DRIVES.into_iter().filter(|id| self.silent != Some(*id)) {
            if self.now_us.is_multiple_of(50_000) {
                frames.extend(Frame::new(0x700 + u16::from(id), &[5]));
            }
            if self.now_us.is_multiple_of(4_000) {
                let position = if id == SCREW { TAUT } else { 0 };
                frames.push(
                    DriveMotion {
                        position,
                        velocity: 0,
                    }
                    .frame(transmit(1), id),
                );
                let statusword = DriveState::OperationEnabled.statusword() | status::REFERENCED;
                frames.push(
                    DriveStatus {
                        statusword,
                        ..DriveStatus::default()
                    }
                    .frame(transmit(2), id),
                );
            }
        }
        let operator = self.command.as_mut().map(|command| {
            command.sequence = command.sequence.wrapping_add(1);
            *command
        });
        let inputs = Inputs {
            now_us: self.now_us,
            body: self.body,
            operator,
            frames: &frames,
            serial: &[],
        };
        let outputs = self.guard.tick(&inputs);
        if outputs.frames.first() == Some(&sync()) {
            self.sent = outputs.frames.to_vec();
        }
        outputs
    }

    fn ask(&mut self, forward: i16) {
        self.command.as_mut().expect("an operator").forward = forward;
    }

    fn track_speeds(&self) -> Vec<i32> {
        let speed = |id| {
            self.sent
                .iter()
                .find_map(|frame| VelocitySetPoint::from_frame(frame, receive(2), id))
        };
        [2, 3]
            .into_iter()
            .filter_map(speed)
            .map(|set_point| set_point.target)
            .collect()
    }
}

fn standing(pitch: f32) -> BodySensors {
    BodySensors {
        inclination: [pitch, 0.0],
        ..BodySensors::default()
    }
}

fn verdict(outputs: &Outputs) -> Option<Verdict> {
    Verdict::from_code(outputs.state.verdict)
}

#[test]
fn level_ground_passes_the_command_to_both_tracks() {
    let mut bench = Bench::armed();
    bench.ask(130);
    let outputs = bench.run(1_000);
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (130, Some(Verdict::Passed))
    );
    // 0.13 m/s on a pulley of 0.05 m.
    for speed in bench.track_speeds() {
        assert!((speed - 2_600_000).abs() < 2_000, "{speed}");
    }
}

#[test]
fn a_margin_below_the_stop_margin_refuses_forward_and_allows_backward() {
    let mut bench = Bench::armed();
    // Turned so far that the centre of gravity, 0.258 m before axle 1, stands 23 mm before it.
    bench.body = Some(BodySensors {
        inclination: [1.48, 0.0],
        ..BodySensors::default()
    });
    bench.run(10_000);
    bench.ask(130);
    let outputs = bench.run(1_000);
    assert_eq!(verdict(&outputs), Some(Verdict::Refused(Edge::Back)));
    assert_eq!(outputs.passed.passed_speed, 0);
    assert!(
        (15..35).contains(&outputs.margins.back),
        "{:?}",
        outputs.margins
    );
    bench.ask(-50);
    let outputs = bench.run(1_000);
    assert_eq!(outputs.passed.passed_speed, -50);
}

#[test]
fn sensors_that_are_no_numbers_stop_the_robot() {
    let mut bench = Bench::armed();
    bench.ask(130);
    bench.run(1_000);
    bench.body = Some(standing(f32::NAN));
    let outputs = bench.run(500);
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (0, Some(Verdict::Blind))
    );
    bench.body = None;
    let outputs = bench.run(500);
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (0, Some(Verdict::Blind))
    );
}

#[test]
fn an_operator_who_falls_silent_stops_the_robot() {
    let mut bench = Bench::armed();
    bench.ask(130);
    bench.run(1_000);
    bench.command = None;
    let outputs = bench.run(800);
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (0, Some(Verdict::Unattended))
    );
}

#[test]
fn the_stop_keeps_to_the_deceleration_in_the_settings() {
    let mut bench = Bench::armed();
    bench.ask(200);
    bench.run(1_000);
    bench.ask(0);
    let mut before = bench.tick().passed.passed_speed;
    while before > 0 {
        let now = bench.run(4).passed.passed_speed;
        // 0.4 m/s^2 over 4 ms, in whole millimetres a second.
        assert!(before - now <= 3, "{before} to {now} mm/s");
        before = now;
    }
}

#[test]
fn a_drive_s_emergency_holds_the_robot_until_the_operator_resets() {
    let mut bench = Bench::armed();
    let code = Fault::Blocked.description().code;
    bench.extra.push(emergency(Emergency { node: 3, code }));
    let outputs = bench.run(10);
    assert_eq!(State::from_code(outputs.state.state), Some(State::Held));
    assert_eq!(
        (outputs.state.fault_node, outputs.state.fault_code),
        (3, code)
    );
    let left = bench
        .sent
        .iter()
        .find_map(|frame| PositionSetPoint::from_frame(frame, receive(1), 2));
    assert_eq!(
        left.map(|set_point| set_point.controlword),
        Some(controlword::QUICK_STOP)
    );

    let still = bench.run(2_000);
    assert_eq!(
        State::from_code(still.state.state),
        Some(State::Held),
        "nothing re-enables by itself"
    );
    bench.command.as_mut().expect("an operator").request = Request::Reset as u8;
    bench.run(20);
    bench.command.as_mut().expect("an operator").request = Request::Arm as u8;
    let outputs = bench.run(500);
    assert_eq!(State::from_code(outputs.state.state), Some(State::Armed));
}

#[test]
fn a_drive_that_falls_silent_is_named_within_the_deadline() {
    let mut bench = Bench::armed();
    bench.silent = Some(4);
    let began = bench.now_us;
    loop {
        let outputs = bench.tick();
        if State::from_code(outputs.state.state) == Some(State::Held) {
            assert_eq!(outputs.state.fault_node, 4);
            break;
        }
        assert!(bench.now_us - began <= 150_000, "not noticed");
    }
}

#[test]
fn a_chassis_motion_that_would_tip_the_robot_is_refused() {
    let mut bench = Bench::armed();
    // Standing on its rear pulleys at 75 degrees; folding the front up would carry the centre of gravity behind them.
    bench.body = Some(standing(1.31));
    bench.run(10_000);
    bench.command.as_mut().expect("an operator").posture = 16_384;
    let outputs = bench.run(2_000);
    assert!(
        matches!(verdict(&outputs), Some(Verdict::PostureRefused(Edge::Back))),
        "{outputs:?}"
    );
    assert!(outputs.passed.passed_posture < 8_192, "{outputs:?}");
}

#[test]
fn a_command_beyond_the_speed_limit_is_the_limit() {
    let mut bench = Bench::armed();
    bench.ask(i16::MAX);
    let outputs = bench.run(3_000);
    assert_eq!(outputs.passed.passed_speed, 450);
}

#[test]
fn the_chassis_turns_no_faster_than_its_limit() {
    let mut bench = Bench::armed();
    bench.command.as_mut().expect("an operator").posture = 3_000;
    let mut before = 0;
    for _ in 0..500 {
        let now = bench.run(4).passed.passed_posture;
        // 0.5 rad/s over 4 ms is 20.9 of 2^-16 turns.
        assert!((now - before).abs() <= 21, "{before} to {now}");
        before = now;
    }
    assert_eq!(before, 3_000);
}
