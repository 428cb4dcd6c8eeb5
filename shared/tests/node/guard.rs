//! The guard's tick among drives that follow every controlword at once.

use tautrack::bus::cia402::{
    CONTROL_FAULT_RESET, DriveCommand, State as DriveState, controlword, status,
};
use tautrack::bus::network::{Emergency, emergency, sync};
use tautrack::bus::pdo::{
    DEAD_MAN_HELD, DriveMotion, DriveStatus, OperatorCommand, Payload, PositionSetPoint, Request,
    VelocitySetPoint, receive, transmit,
};
use tautrack::can::Frame;
use tautrack::faults::Fault;
use tautrack::node::guard::{Guard, Inputs, Outputs, POSITION_SCALE, State};
use tautrack::robots::b2p2::B2p2;
use tautrack::sensors::BodySensors;
use tautrack::settings::{Setting, Settings};
use tautrack::stability::bands::Band;
use tautrack::stability::filter::Verdict;
use tautrack::stability::parameters::Refusal;
use tautrack::stability::support::Edge;
use tautrack::stability::trip::Cause;
use tautrack::stability::trust::{Reason, Trust};

const DRIVES: [u8; 4] = [2, 3, 4, 5];
/// What the drives answer when the guard asks for their position scales.
const SCALES: [u16; 4] = [16, 16, 32, 0x118];
const JOINT: u8 = 4;
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
    /// Where the chassis joint is: where the guard sent it.
    joint: i32,
    states: [DriveState; 4],
    scales: [u16; 4],
    /// Error codes in the drives' status.
    errors: [u16; 4],
    sent: Vec<Frame>,
    emergency_stop: bool,
}

impl Bench {
    fn armed() -> Self {
        let mut bench = Self::with(&[]);
        let outputs = bench.run(4);
        assert_eq!(State::from_code(outputs.state.state), Some(State::Armed));
        bench
    }

    fn with(changes: &[(Setting, i32)]) -> Self {
        let mut settings = Settings::default();
        for (setting, value) in changes {
            settings
                .set(setting.description().key, *value)
                .expect("a value within bounds");
        }
        let mut bench = Self::new(&settings);
        bench.run(200);
        bench.request(Request::Arm);
        bench.run(800);
        bench
    }

    fn new(settings: &Settings) -> Self {
        Self {
            guard: Guard::new(settings).expect("the default robot is good"),
            now_us: 0,
            command: Some(OperatorCommand {
                request: Request::Stop as u8,
                ..OperatorCommand::default()
            }),
            body: Some(standing(0.0)),
            extra: Vec::new(),
            silent: None,
            joint: 0,
            states: [DriveState::SwitchOnDisabled; 4],
            scales: SCALES,
            errors: [0; 4],
            sent: Vec::new(),
            emergency_stop: false,
        }
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
        for (index, id) in DRIVES.into_iter().enumerate() {
            if self.silent == Some(id) {
                continue;
            }
            if self.now_us.is_multiple_of(50_000) {
                frames.extend(Frame::new(0x700 + u16::from(id), &[5]));
            }
            if self.now_us.is_multiple_of(4_000) {
                let position = match id {
                    SCREW => TAUT,
                    JOINT => self.joint,
                    _ => 0,
                };
                frames.push(
                    DriveMotion {
                        position,
                        velocity: 0,
                    }
                    .frame(transmit(1), id),
                );
                let statusword = self.states[index].statusword() | status::REFERENCED;
                frames.push(
                    DriveStatus {
                        statusword,
                        error_code: self.errors[index],
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
            body: self.body.map(|reading| noisy(reading, self.now_us / 1_000)),
            operator,
            emergency_stop: self.emergency_stop,
            frames: &frames,
            serial: &[],
        };
        let outputs = self.guard.tick(&inputs).clone();
        if outputs.frames.first() == Some(&sync()) {
            self.sent = outputs.frames.to_vec();
            self.follow();
        }
        outputs
    }

    /// Every drive takes its controlword, and answers a request for its scale.
    fn follow(&mut self) {
        let joint = |frame| PositionSetPoint::from_frame(frame, receive(1), JOINT);
        if let Some(set_point) = self.sent.iter().find_map(joint) {
            self.joint = set_point.target;
        }
        for (index, id) in DRIVES.into_iter().enumerate() {
            if let Some(word) = self.controlword(id) {
                let state = &mut self.states[index];
                *state = state.after(DriveCommand::from_controlword(word));
            }
            let request = 0x600 + u16::from(id);
            if self.sent.iter().any(|frame| frame.id() == request) {
                let ([low, high], [a, b]) = (
                    POSITION_SCALE.to_le_bytes(),
                    self.scales[index].to_le_bytes(),
                );
                let answer = [0x4b, low, high, 0, a, b, 0, 0];
                self.extra
                    .extend(Frame::new(0x580 + u16::from(id), &answer));
            }
        }
    }

    /// The controlword that the guard sent last to drive `id`.
    fn controlword(&self, id: u8) -> Option<u16> {
        self.sent.iter().find_map(|frame| {
            let position = PositionSetPoint::from_frame(frame, receive(1), id);
            let velocity = VelocitySetPoint::from_frame(frame, receive(2), id);
            position
                .map(|point| point.controlword)
                .or(velocity.map(|point| point.controlword))
        })
    }

    /// Turns the robot nose up within twelve seconds, as all its sensors show it, and holds it there.
    fn tilt(&mut self, pitch: f32) {
        for step in 0..12_000 {
            let turning = standing(pitch * step as f32 / 12_000.0);
            self.body = Some(BodySensors {
                angular_rate: [0.0, -pitch / 12.0, 0.0],
                ..turning
            });
            self.tick();
        }
        self.body = Some(standing(pitch));
        self.run(3_000);
    }

    fn request(&mut self, request: Request) {
        self.command.as_mut().expect("an operator").request = request as u8;
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
        // What an accelerometer shows there.
        specific_force: [9.81 * pitch.sin(), 0.0, 9.81 * pitch.cos()],
        ..BodySensors::default()
    }
}

/// The same reading as a sensor gives it: its last digit dances.
fn noisy(reading: BodySensors, step: u64) -> BodySensors {
    let noise = |channel: u64| 1e-6 * ((step * 7 + channel * 3) % 5) as f32;
    let [pitch, roll] = reading.inclination;
    let [x, y, z] = reading.specific_force;
    let [rate_x, rate_y, rate_z] = reading.angular_rate;
    BodySensors {
        inclination: [pitch + noise(0), roll + noise(1)],
        specific_force: [x + noise(2), y + noise(3), z + noise(4)],
        angular_rate: [rate_x + noise(5), rate_y + noise(6), rate_z + noise(7)],
        ..reading
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
fn a_margin_below_the_stop_margin_refuses_forward_and_lets_the_robot_back_out_slowly() {
    let mut bench = Bench::armed();
    // Turned so far that the centre of gravity, 0.258 m before axle 1, stands 23 mm before it.
    bench.tilt(1.48);
    bench.ask(130);
    let outputs = bench.run(1_000);
    assert_eq!(verdict(&outputs), Some(Verdict::Refused(Edge::Back)));
    assert_eq!(outputs.passed.passed_speed, 0);
    assert!(
        (15..35).contains(&outputs.margins.back),
        "{:?}",
        outputs.margins
    );
    // 13 of the 40 mm between trip and stop margin are left.
    bench.ask(-50);
    let outputs = bench.run(1_000);
    let expected = -16 - 2..=-16 + 2;
    assert!(
        expected.contains(&outputs.passed.passed_speed),
        "{outputs:?}"
    );
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
        (0, Some(Verdict::Blind(Reason::NotFinite)))
    );
    bench.body = None;
    let outputs = bench.run(500);
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (0, Some(Verdict::Blind(Reason::Silent)))
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
    bench.request(Request::Reset);
    bench.run(20);
    bench.request(Request::Arm);
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
    bench.tilt(1.31);
    bench.command.as_mut().expect("an operator").posture = 16_384;
    let outputs = bench.run(2_000);
    assert!(
        matches!(verdict(&outputs), Some(Verdict::PostureRefused(_))),
        "{outputs:?}"
    );
    assert!(outputs.passed.passed_posture < 8_192, "{outputs:?}");
}

/// On level ground the front, folded down by 60 degrees, lifts the body by 36. From there a fall off a
/// step of 100 mm is borne, and one of 150 mm is not.
#[test]
fn a_step_that_may_be_behind_limits_backing_and_how_far_the_front_is_folded_down() {
    let fold = |step: i32| {
        let mut bench = Bench::with(&[(Setting::StepBehind, step)]);
        bench.tilt(0.63);
        // -60 degrees.
        bench.command.as_mut().expect("an operator").posture = -10_923;
        let folded = bench.run(5_000);
        bench.ask(-300);
        let backed = bench.run(3_000);
        // Forward and unfolding are free.
        bench.ask(100);
        bench.command.as_mut().expect("an operator").posture = 0;
        let freed = bench.run(5_000);
        assert_eq!(freed.passed.passed_posture, 0, "{freed:?}");
        assert_eq!(freed.passed.passed_speed, 100, "{freed:?}");
        (folded, backed)
    };
    for step in [0, 100_000] {
        let (folded, backed) = fold(step);
        assert_eq!(folded.passed.passed_posture, -10_923, "{folded:?}");
        assert_eq!(backed.passed.passed_speed, -300, "{backed:?}");
    }
    let (folded, backed) = fold(150_000);
    assert_eq!(verdict(&folded), Some(Verdict::PostureRefused(Edge::Back)));
    let reached = f64::from(folded.passed.passed_posture) * 360.0 / 65_536.0;
    assert!((-58.0..-35.0).contains(&reached), "{reached}");
    assert!(backed.passed.passed_speed > -100, "{backed:?}");
    let held_back = [Verdict::Scaled(Edge::Back), Verdict::Refused(Edge::Back)];
    assert!(verdict(&backed).is_some_and(|verdict| held_back.contains(&verdict)));
}

/// A set-point that the joint reaches within one SYNC period has no velocity afterwards.
#[test]
fn small_steps_fold_the_front_no_farther_than_a_large_one() {
    let fold = |step: i16| {
        let changes = [
            (Setting::StepBehind, 150_000),
            (Setting::SyncPeriod, 20_000),
        ];
        let mut bench = Bench::with(&changes);
        bench.tilt(0.63);
        let mut outputs = bench.run(20);
        for _ in 0..1_000 {
            let command = bench.command.as_mut().expect("an operator");
            command.posture = (command.posture - step).max(-10_923);
            outputs = bench.run(20);
        }
        outputs.passed.passed_posture
    };
    let at_once = fold(10_923);
    assert!(at_once > -10_500, "{at_once}");
    let in_steps = fold(12);
    // 1.6 degrees.
    assert!((in_steps - at_once).abs() < 300, "{in_steps} {at_once}");
}

/// The way out of a posture in which backing is refused.
#[test]
fn a_raised_front_is_lowered_to_straight_whatever_may_be_behind() {
    let mut bench = Bench::with(&[(Setting::StepBehind, 500_000)]);
    bench.command.as_mut().expect("an operator").posture = 8_000;
    bench.run(4_000);
    bench.ask(-100);
    let raised = bench.run(1_000).passed;
    assert_eq!((raised.passed_speed, raised.passed_posture), (0, 8_000));
    bench.command.as_mut().expect("an operator").posture = 0;
    assert_eq!(bench.run(4_000).passed.passed_posture, 0);
}

#[test]
fn a_command_beyond_the_speed_limit_is_the_limit() {
    let mut bench = Bench::armed();
    bench.ask(i16::MAX);
    let outputs = bench.run(3_000);
    // The yaw that holds the heading takes a little of it: each belt stays within the limit.
    assert!((420..=450).contains(&outputs.passed.passed_speed));
    for speed in bench.track_speeds() {
        // 0.45 m/s on a pulley of 0.05 m.
        assert!(speed <= 9_000_000, "{speed}");
    }
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

/// Stands on its rear pulleys with its centre of gravity 5 mm before them.
const TRIPPING: f32 = 1.551;

#[test]
fn a_trip_latches_and_the_override_leaves_it_at_crawl_speed() {
    let mut bench = Bench::armed();
    bench.ask(130);
    bench.tilt(TRIPPING);
    let outputs = bench.run(200);
    assert_eq!(verdict(&outputs), Some(Verdict::Tripped(Edge::Back)));
    let known = bench.guard.telemetry();
    assert_eq!((known.band, known.trips), (Band::Stop, 1));
    let kept = known.snapshot.expect("a snapshot");
    assert_eq!(kept.cause, Cause::Margin(Edge::Back));
    assert!(
        (kept.asked.forward - 0.13).abs() < 1e-6 && kept.margins[0] < 0.01,
        "{kept:?}"
    );

    // Not even backward, and no reset while the margin is gone.
    bench.ask(-130);
    assert_eq!(bench.run(500).passed.passed_speed, 0);
    bench.request(Request::Reset);
    bench.run(100);
    bench.request(Request::Arm);
    assert_eq!(bench.run(500).passed.passed_speed, 0);
    bench.request(Request::Override);
    let outputs = bench.run(500);
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (-50, Some(Verdict::Overridden(Edge::Back)))
    );
    bench.tilt(0.3);
    bench.request(Request::Arm);
    assert_eq!(bench.run(500).passed.passed_speed, 0, "still tripped");
    bench.request(Request::Reset);
    bench.run(100);
    bench.request(Request::Arm);
    assert_eq!(bench.run(1_000).passed.passed_speed, -130);
}

#[test]
fn backing_off_goes_back_at_crawl_speed_where_a_setting_allows_it() {
    for (allowed, expected) in [(0, 0), (1, -50)] {
        let mut bench = Bench::with(&[(Setting::BackOff, allowed)]);
        bench.ask(130);
        bench.tilt(TRIPPING);
        bench.request(Request::BackOff);
        assert_eq!(bench.run(500).passed.passed_speed, expected);
        bench.command = None;
        assert_eq!(bench.run(800).passed.passed_speed, 0, "held to run");
    }
}

#[test]
fn an_emergency_stop_by_anybody_stops_and_latches() {
    let mut bench = Bench::armed();
    bench.ask(130);
    bench.run(1_000);
    bench.emergency_stop = true;
    let outputs = bench.run(500);
    assert_eq!(outputs.passed.passed_speed, 0);
    bench.emergency_stop = false;
    assert_eq!(
        bench.run(500).passed.passed_speed,
        0,
        "released, not cleared"
    );
    bench.request(Request::Reset);
    bench.run(10);
    bench.request(Request::Arm);
    assert_eq!(bench.run(1_000).passed.passed_speed, 130);
}

#[test]
fn nothing_passes_unless_the_dead_man_switch_is_held() {
    let mut bench = Bench::with(&[(Setting::DeadMan, 1)]);
    let outputs = bench.run(1_000);
    assert_eq!(State::from_code(outputs.state.state), Some(State::Ready));
    bench.command.as_mut().expect("an operator").request |= DEAD_MAN_HELD;
    bench.ask(130);
    assert_eq!(bench.run(2_000).passed.passed_speed, 130);
    bench.request(Request::Arm);
    let outputs = bench.run(1_000);
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (0, Some(Verdict::Unattended))
    );
}

#[test]
fn an_attitude_that_the_accelerometer_denies_slows_the_robot_and_then_stops_it() {
    let mut bench = Bench::armed();
    bench.ask(130);
    bench.run(1_000);
    // The inclinometer has come loose.
    bench.body = Some(BodySensors {
        inclination: [-0.4, 0.0],
        ..standing(0.0)
    });
    let (mut slowed, mut stopped) = (false, false);
    for _ in 0..6_000 {
        let outputs = bench.tick();
        slowed |= verdict(&outputs) == Some(Verdict::Doubted(Reason::Disagreement))
            && outputs.passed.passed_speed == 50;
        stopped |= outputs.passed.passed_speed == 0;
    }
    assert!(slowed && stopped);
    let known = bench.guard.telemetry();
    assert_eq!(known.trust, Trust::None(Reason::Disagreement));
    assert_eq!(
        known.snapshot.map(|kept| kept.cause),
        Some(Cause::Sensors(Reason::Disagreement))
    );
}

#[test]
fn settings_that_make_no_sense_are_not_armed() {
    let bench = Bench::with(&[(Setting::StopMargin, 95_000)]);
    assert!(matches!(
        bench.guard.telemetry().refusal,
        Some(Refusal::Levels { .. })
    ));
    // A load that would put the centre of gravity behind the rear edge.
    let mut bench = Bench::with(&[
        (Setting::PayloadMass, 20_000),
        (Setting::PayloadForward, -200_000),
    ]);
    let refusal = bench.guard.telemetry().refusal;
    assert!(
        matches!(refusal, Some(Refusal::CogOutside { edge: Edge::Back, margin }) if margin < 0.0),
        "{refusal:?}"
    );
    let outputs = bench.run(1_000);
    assert_eq!(State::from_code(outputs.state.state), Some(State::Ready));
}

#[test]
fn an_undeclared_load_narrows_every_margin_by_what_it_can_do() {
    let margins = |mass| {
        let mut bench = Bench::with(&[(Setting::MassUncertainty, mass)]);
        bench.run(100).margins
    };
    let (without, with) = (margins(0), margins(1_000));
    // 1 kg of 9.315 kg, 0.3 m away: 32 mm.
    for (before, after) in [(without.back, with.back), (without.left, with.left)] {
        assert!((before - after - 32).abs() <= 1, "{without:?} {with:?}");
    }
}

#[test]
fn a_reset_is_a_pulse_and_each_reset_has_its_edge() {
    let mut bench = Bench::armed();
    // The supply is too low, and stays so for two seconds.
    bench.errors[1] = Fault::UnderVoltage.description().code;
    bench.states[1] = DriveState::Fault;
    assert_eq!(
        State::from_code(bench.run(50).state.state),
        Some(State::Held),
        "seen in the status alone: its emergency frame was lost"
    );
    let mut edges = 0;
    let mut before = false;
    for reset in 0..6 {
        bench.request(Request::Stop);
        bench.run(100);
        bench.request(Request::Reset);
        let mut high_ms = 0;
        for _ in 0..200 {
            bench.tick();
            let high = bench.controlword(3).expect("a set-point") & CONTROL_FAULT_RESET != 0;
            edges += u32::from(high && !before);
            high_ms += u32::from(high);
            before = high;
        }
        assert!(
            !before && high_ms <= 40,
            "reset {reset}: high for {high_ms} ms"
        );
        let outputs = bench.run(4);
        assert_eq!(State::from_code(outputs.state.state), Some(State::Held));
        assert_eq!(
            outputs.faulty_drives, 0b10,
            "the left drive is not to blame"
        );
    }
    assert_eq!(edges, 6);
    // The supply is back: the next reset clears the fault.
    bench.errors[1] = 0;
    bench.states[1] = DriveState::SwitchOnDisabled;
    bench.request(Request::Stop);
    bench.run(100);
    bench.request(Request::Reset);
    let outputs = bench.run(200);
    assert_eq!(State::from_code(outputs.state.state), Some(State::Ready));
    assert_eq!(outputs.faulty_drives, 0);
}

#[test]
fn a_drive_that_counts_in_another_scale_is_named_with_both_values() {
    let mut bench = Bench::new(&Settings::default());
    // position_bits of the joint, changed at the axle only.
    bench.scales[2] = 24;
    bench.run(200);
    bench.request(Request::Arm);
    let outputs = bench.run(1_000);
    assert_eq!(State::from_code(outputs.state.state), Some(State::Ready));
    let code = Fault::ScaleMismatch.description().code;
    assert_eq!(
        (outputs.state.fault_node, outputs.state.fault_code),
        (4, code)
    );
    let mismatch = bench.guard.scale_mismatch().expect("both values");
    assert_eq!(
        (mismatch.node, mismatch.expected, mismatch.found),
        (4, 32, 24)
    );
}

/// At each phase of the SYNC period.
#[test]
fn a_reset_does_not_hide_that_a_drive_has_started_anew() {
    for phase in 0..4 {
        let mut bench = Bench::new(&Settings::default());
        bench.run(200 + phase);
        assert_eq!(bench.guard.scale_mismatch(), None);
        bench.scales[2] = 24;
        bench.states[2] = DriveState::SwitchOnDisabled;
        bench
            .extra
            .extend(Frame::new(0x700 + u16::from(JOINT), &[0]));
        bench.request(Request::Reset);
        bench.run(200);
        let found = bench.guard.scale_mismatch().map(|scales| scales.found);
        assert_eq!(found, Some(24), "phase {phase}");
    }
}

#[test]
fn a_drive_whose_motion_or_status_stays_out_is_lost() {
    for missing in ["motion", "status"] {
        let mut bench = Bench::armed();
        bench.silent = Some(3);
        for _ in 0..100 {
            // The rest of what it sends still comes.
            bench.extra.extend(Frame::new(0x703, &[5]));
            let statusword = DriveState::OperationEnabled.statusword();
            bench.extra.push(if missing == "motion" {
                let status = DriveStatus {
                    statusword,
                    ..DriveStatus::default()
                };
                status.frame(transmit(2), 3)
            } else {
                DriveMotion::default().frame(transmit(1), 3)
            });
            bench.tick();
        }
        let outputs = bench.tick();
        let state = State::from_code(outputs.state.state);
        let code = Fault::NodeLost.description().code;
        assert_eq!(
            (state, outputs.state.fault_node, outputs.state.fault_code),
            (Some(State::Held), 3, code),
            "{missing}"
        );
    }
}

#[test]
fn an_override_is_for_margins_only() {
    for (cause, moves) in [("margin", true), ("emergency stop", false)] {
        let mut bench = Bench::armed();
        bench.ask(130);
        bench.tilt(TRIPPING);
        bench.emergency_stop = cause == "emergency stop";
        bench.run(100);
        bench.emergency_stop = false;
        bench.ask(-130);
        bench.request(Request::Override);
        let speed = bench.run(1_000).passed.passed_speed;
        assert_eq!(speed != 0, moves, "{cause}: {speed} mm/s");
    }
}
