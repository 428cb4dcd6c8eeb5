//! Tests of what the drives do while the robot is not armed: what holds goes on holding, what rolls
//! is braked, and what would topple the robot is refused.

use super::bench::{Bench, DRIVES, JOINT, standing};
use tautrack::bus::cia402::{State as DriveState, controlword};
use tautrack::bus::pdo::Request;
use tautrack::can::Frame;
use tautrack::faults::Fault;
use tautrack::node::guard::State;
use tautrack::robots::b2p2::B2p2;
use tautrack::robots::crawler::Crawler;
use tautrack::robots::hylos::Hylos;
use tautrack::robots::rt_mover::RtMover;
use tautrack::robots::{Body, Goal, Phase};
use tautrack::sensing::trust::Reason;
use tautrack::sensors::BodySensors;
use tautrack::settings::{Setting, Settings};
use tautrack::stability::parameters::Refusal;
use tautrack::stability::support::Edge;

fn state(bench: &Bench) -> State {
    State::from_code(bench.guard.outputs().state.state).expect("a state")
}

fn powered(bench: &Bench) -> [bool; 4] {
    let under_power = [DriveState::OperationEnabled, DriveState::QuickStopActive];
    bench.states.map(|state| under_power.contains(&state))
}

/// A node restarts: it boots, and its drive is off and not homed.
fn restart(bench: &mut Bench, index: usize) {
    bench.states[index] = DriveState::SwitchOnDisabled;
    bench.homed[index] = false;
    let boot_up = 0x700 + u16::from(DRIVES[index]);
    bench.extra.extend(Frame::new(boot_up, &[0]));
}

/// A set-point for the left track that another master sends.
fn foreign_set_point() -> Frame {
    Frame::new(0x302, &[0x0f, 0, 9, 0, 0, 1, 0]).expect("a frame")
}

/// Runs `ticks`, and asserts that no drive of `holding` lets go.
fn run_holding(bench: &mut Bench, holding: [bool; 4], ticks: u32) {
    for _ in 0..ticks {
        bench.tick();
        for (index, holds) in holding.into_iter().enumerate() {
            let now = powered(bench)[index];
            assert!(now || !holds, "drive {index} let go, {:?}", state(bench));
        }
    }
}

#[test]
fn no_body_commands_a_drive_off() {
    fn check<B: Body>() {
        let settings = Settings::default();
        let body = B::new(&settings).expect("the default robot is good");
        let stages = (0..B::STAGES.len() as u8).map(Phase::Starting);
        for phase in stages.chain([Phase::Armed, Phase::Held]) {
            for drive in 0..B::drive_ids(&settings).len() {
                assert_ne!(body.goal(phase, drive), Goal::Off, "{phase:?} {drive}");
            }
        }
    }
    check::<B2p2>();
    check::<Crawler>();
    check::<Hylos>();
    check::<RtMover>();
}

/// Any drive restarts on a slope of 29 degrees, so that its home is lost.
#[test]
fn arming_again_on_a_slope_lets_no_drive_go_and_homes_nothing_before_it_is_confirmed() {
    for index in 0..4 {
        let mut bench = Bench::armed();
        bench.tilt(0.5);
        restart(&mut bench, index);
        let mut holding = [true; 4];
        holding[index] = false;
        run_holding(&mut bench, holding, 100);
        assert_eq!(state(&bench), State::Held);
        for (request, ticks) in [(Request::Reset, 100), (Request::Stop, 100)] {
            bench.request(request);
            run_holding(&mut bench, holding, ticks);
        }
        bench.request(Request::Arm);
        run_holding(&mut bench, holding, 2_000);
        assert!(!bench.homed[index], "drive {index}");
        let refusal = bench.guard.telemetry().refusal;
        assert!(
            matches!(refusal, Some(Refusal::OffLevel { tilt }) if (tilt - 0.5).abs() < 0.02),
            "{refusal:?}"
        );
        bench.request(Request::Stop);
        run_holding(&mut bench, holding, 100);
        bench.request(Request::ArmOffLevel);
        run_holding(&mut bench, holding, 2_000);
        assert_eq!(state(&bench), State::Armed);
        assert_eq!(bench.guard.telemetry().refusal, None);
    }
}

#[test]
fn homing_off_level_ground_is_refused_whatever_axis_is_tilted() {
    for tilt in [[0.15, 0.0], [-0.15, 0.0], [0.0, 0.15], [0.0, -0.15]] {
        for homed in [false, true] {
            let mut bench = Bench::new(&Settings::default());
            bench.homed = [homed; 4];
            let [pitch, roll] = tilt;
            bench.body = Some(BodySensors {
                inclination: tilt,
                specific_force: [9.81 * pitch.sin(), 9.81 * roll.sin(), 9.81 * 0.15_f32.cos()],
                ..BodySensors::default()
            });
            bench.run(1_000);
            bench.request(Request::Arm);
            bench.run(1_000);
            let refusal = bench.guard.telemetry().refusal;
            let refused = matches!(refusal, Some(Refusal::OffLevel { .. }));
            assert_eq!(refused, !homed, "{tilt:?} {refusal:?}");
            assert_eq!(powered(&bench), [homed; 4], "{tilt:?}");
        }
    }
}

/// On a slope of 34 degrees with 4 kg above its middle, the simulated robot was toppled by a home
/// switch that is stuck closed: the front folded down, and the margin behind fell to -61 mm.
#[test]
fn homing_that_would_topple_the_robot_is_refused_before_anything_moves() {
    for payload in [0, 4_000] {
        let mut bench = Bench::with(&[
            (Setting::PayloadMass, payload),
            (Setting::PayloadForward, 140_000),
            (Setting::PayloadUp, 250_000),
        ]);
        bench.tilt(34.0_f32.to_radians());
        bench.request(Request::Stop);
        restart(&mut bench, 2);
        bench.run(100);
        bench.request(Request::Reset);
        bench.run(100);
        bench.request(Request::ArmOffLevel);
        let before = powered(&bench);
        let refusal = |bench: &Bench| bench.guard.telemetry().refusal;
        while refusal(&bench).is_none() && state(&bench) != State::Armed {
            bench.tick();
        }
        match refusal(&bench) {
            None => assert_eq!(payload, 0),
            Some(Refusal::Margin {
                edge: Edge::Back,
                margin,
            }) => {
                assert!((margin + 0.061).abs() < 0.02, "{margin}");
                assert_eq!((payload, powered(&bench)), (4_000, before));
                assert!(!bench.homed[2]);
            }
            other => panic!("{payload} g: {other:?}"),
        }
    }
}

/// In each stage that homes, something turns the robot until it nearly falls.
#[test]
fn a_stage_that_homes_ends_when_the_margin_or_the_sensors_are_lost() {
    for stage in 0..3 {
        for blind in [false, true] {
            let mut bench = Bench::new(&Settings::default());
            bench.homed = [true, true, false, false];
            bench.run(1_000);
            bench.request(Request::ArmOffLevel);
            while state(&bench) != State::Starting(stage) {
                bench.tick();
            }
            // Drives that take long keep the guard in its stage.
            bench.aligns_until_us = u64::MAX;
            bench.homed = [true, true, stage > 1, stage > 0];
            bench.joint_held = Some(100_000_000);
            bench.run(60);
            if blind {
                bench.body = None;
            } else {
                bench.body = Some(standing(1.56));
            }
            bench.run(4_000);
            assert_eq!(state(&bench), State::Ready, "stage {stage}, {blind}");
            let refusal = bench.guard.telemetry().refusal;
            let named = match refusal {
                Some(Refusal::Sensors { reason }) => blind == (reason == Reason::Silent),
                Some(Refusal::Margin { .. }) => !blind,
                _ => false,
            };
            assert!(named, "stage {stage}, {blind}: {refusal:?}");
            let words = DRIVES.map(|id| bench.controlword(id));
            assert_eq!(words, [Some(controlword::QUICK_STOP); 4]);
        }
    }
}

/// The operator stops the start on level ground, and somebody carries the robot onto a slope.
#[test]
fn a_start_that_was_stopped_begins_with_all_checks_again() {
    let mut bench = Bench::new(&Settings::default());
    bench.homed = [true, true, false, false];
    bench.run(1_000);
    bench.request(Request::Arm);
    while state(&bench) != State::Starting(0) {
        bench.tick();
    }
    bench.aligns_until_us = u64::MAX;
    bench.homed = [true, true, false, false];
    bench.request(Request::Stop);
    bench.run(200);
    assert_eq!(state(&bench), State::Starting(0));
    bench.tilt(0.5);
    bench.request(Request::Arm);
    bench.run(1_000);
    assert_eq!(state(&bench), State::Ready);
    let refusal = bench.guard.telemetry().refusal;
    assert!(
        matches!(refusal, Some(Refusal::OffLevel { .. })),
        "{refusal:?}"
    );
}

#[test]
fn tracks_hold_in_every_stage_of_homing() {
    let mut bench = Bench::new(&Settings::default());
    bench.homed = [true, true, false, false];
    bench.run(1_000);
    bench.request(Request::Arm);
    let mut held = [false; 4];
    for _ in 0..2_000 {
        bench.tick();
        if let State::Starting(stage) = state(&bench) {
            let [left, right, ..] = powered(&bench);
            held[usize::from(stage)] |= left && right;
        }
    }
    assert_eq!(held, [true; 4]);
    assert_eq!(state(&bench), State::Armed);
}

#[test]
fn no_drive_starts_without_sensors_and_the_refusal_says_so() {
    // From power-up, and lost while the robot is held.
    for lost in [false, true] {
        let mut bench = if lost {
            Bench::armed()
        } else {
            Bench::new(&Settings::default())
        };
        if lost {
            bench.request(Request::Disarm);
            bench.run(100);
        }
        bench.homed = [lost; 4];
        bench.body = None;
        bench.request(Request::Stop);
        bench.run(1_000);
        bench.request(Request::Arm);
        for _ in 0..1_000 {
            bench.tick();
            assert_eq!((state(&bench), powered(&bench)), (State::Ready, [false; 4]));
        }
        let refusal = bench.guard.telemetry().refusal;
        let reason = Reason::Silent;
        assert_eq!(refusal, Some(Refusal::Sensors { reason }), "lost: {lost}");
    }
}

#[test]
fn a_guard_whose_settings_are_not_whole_starts_no_drive() {
    let mut bench = Bench::new(&Settings::default());
    bench.guard.doubt_settings();
    bench.run(1_000);
    bench.request(Request::Arm);
    bench.run(1_000);
    assert_eq!((state(&bench), powered(&bench)), (State::Ready, [false; 4]));
    assert_eq!(bench.guard.telemetry().refusal, Some(Refusal::Settings));
}

/// The robot is disarmed on a slope, and its left track rolls at 1 rad/s.
#[test]
fn every_request_but_disarm_brakes_a_track_that_rolls() {
    for request in [
        Request::Stop,
        Request::EmergencyStop,
        Request::Reset,
        Request::Arm,
        Request::Disarm,
    ] {
        for from in [State::Ready, State::Held] {
            let mut bench = Bench::armed();
            if from == State::Held {
                bench.errors[3] = Fault::Blocked.code();
                bench.states[3] = DriveState::Fault;
                bench.run(20);
            }
            bench.request(Request::Disarm);
            bench.run(20);
            assert_eq!(powered(&bench), [false; 4]);
            bench.tilt(0.3);
            bench.velocities[0] = -1_000_000;
            // It may not be armed here.
            bench.homed[1] = false;
            bench.run(600);
            assert_eq!(powered(&bench), [false; 4], "as the operator requested");
            bench.request(request);
            bench.run(40);
            let brakes = request != Request::Disarm;
            assert_eq!(
                powered(&bench),
                [brakes, false, false, false],
                "{request:?}"
            );
            bench.velocities[0] = 0;
            run_holding(&mut bench, [brakes, false, false, false], 600);
        }
    }
}

/// The load turns it, and it does not hold after its restart.
#[test]
fn a_joint_that_held_before_it_restarted_is_braked_unless_the_operator_disarms() {
    for request in [Request::Arm, Request::Disarm] {
        let mut bench = Bench::armed();
        bench.request(request);
        bench.run(100);
        restart(&mut bench, 2);
        bench.run(20);
        assert!(!powered(&bench)[2]);
        for turn in 0..20 {
            // 0.2 rad/s.
            bench.joint_held = Some(turn * -550_000);
            bench.run(4);
        }
        assert_eq!(powered(&bench)[2], request == Request::Arm, "{request:?}");
    }
}

#[test]
fn an_emergency_stop_brakes_a_track_that_rolls_while_the_operator_requests_motors_off() {
    let mut bench = Bench::armed();
    bench.request(Request::Disarm);
    bench.run(100);
    bench.velocities[0] = -1_000_000;
    bench.run(100);
    assert_eq!(powered(&bench), [false; 4]);
    bench.emergency_stop = true;
    bench.run(100);
    assert_eq!(powered(&bench), [true, false, false, false]);
    bench.emergency_stop = false;
    bench.run(100);
    assert_eq!(powered(&bench), [false; 4], "as the operator requests");
}

/// A joint that somebody moves by hand is not enabled, and no drive before an operator is there.
#[test]
fn only_tracks_are_braked_and_only_for_an_operator() {
    let mut bench = Bench::new(&Settings::default());
    for turn in 0..100 {
        // 0.2 rad/s.
        bench.joint_held = Some(turn * 550_000);
        bench.run(4);
        assert_eq!(powered(&bench), [false; 4]);
    }
    let mut bench = Bench::new(&Settings::default());
    bench.command = None;
    bench.velocities = [1_000_000; 2];
    bench.run(600);
    assert_eq!(powered(&bench), [false; 4]);
}

#[test]
fn a_holding_drive_that_lets_go_is_reported_within_20_ms_in_every_state() {
    for restarts in [false, true] {
        for held in [false, true] {
            let mut bench = Bench::armed();
            bench.run(200);
            let track = Fault::Blocked;
            if held {
                bench.errors[0] = track.code();
                bench.states[0] = DriveState::Fault;
                bench.run(100);
                assert_eq!(state(&bench), State::Held);
            } else {
                bench.extra.push(foreign_set_point());
                bench.run(20);
                bench.request(Request::Reset);
                bench.run(20);
                assert_eq!(state(&bench), State::Ready);
            }
            assert!(powered(&bench)[2], "the joint holds");
            if restarts {
                restart(&mut bench, 2);
            } else {
                bench.states[2] = DriveState::SwitchOnDisabled;
            }
            let outputs = bench.run(20);
            let code = if restarts {
                Fault::NodeLost.code()
            } else {
                Fault::UnexpectedState.code()
            };
            let found = (outputs.state.fault_node, outputs.state.fault_code);
            assert_eq!(found, (JOINT, code), "restarts {restarts}, held {held}");
        }
    }
}

/// Somebody's own fault says why it lets go.
#[test]
fn a_holding_drive_that_lets_go_with_a_fault_is_reported_with_it() {
    let mut bench = Bench::armed();
    bench.extra.push(foreign_set_point());
    bench.run(20);
    bench.request(Request::Reset);
    bench.run(20);
    bench.states[2] = DriveState::Fault;
    bench.errors[2] = Fault::OverCurrent.code();
    let outputs = bench.run(20);
    let found = (outputs.state.fault_node, outputs.state.fault_code);
    assert_eq!(found, (JOINT, Fault::OverCurrent.code()));
}

#[test]
fn a_guard_that_waits_reports_a_second_master_and_holds_the_drives_that_it_knows() {
    let mut bench = Bench::new(&Settings::default());
    bench.silent = Some(5);
    // Another program has started the network and drives a track.
    bench.states[0] = DriveState::OperationEnabled;
    bench.run(100);
    assert_eq!(state(&bench), State::Waiting);
    assert_eq!(bench.states[0], DriveState::QuickStopActive);
    bench.extra.push(foreign_set_point());
    let outputs = bench.tick();
    let found = (outputs.state.fault_node, outputs.state.fault_code);
    assert_eq!(found, (2, Fault::SecondMaster.code()));
}
