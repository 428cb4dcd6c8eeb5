//! Tests of arming: its stages, its end by the operator, and the start command of the network.

use super::bench::{Bench, DRIVES, JOINT, standing, verdict};
use tautrack::bus::cia402::controlword;
use tautrack::bus::network::{Emergency, NmtCommand, emergency, nmt};
use tautrack::bus::pdo::{DriveMotion, Payload, Request, transmit};
use tautrack::can::Frame;
use tautrack::faults::Fault;
use tautrack::node::guard::State;
use tautrack::settings::{Setting, Settings};
use tautrack::stability::filter::Verdict;

fn state(bench: &mut Bench) -> State {
    let outputs = bench.run(4);
    State::from_code(outputs.state.state).expect("a state")
}

/// A guard in the middle of its stages.
fn starting() -> Bench {
    let mut bench = Bench::new(&Settings::default());
    bench.run(200);
    // Drives that need long for their alignment keep the guard in its stage.
    bench.aligns_until_us = u64::MAX;
    bench.request(Request::Arm);
    bench.run(100);
    assert!(matches!(state(&mut bench), State::Starting(_)));
    assert!(
        words(&bench).contains(&controlword::ENABLE_OPERATION),
        "a drive is being enabled"
    );
    bench
}

fn words(bench: &Bench) -> [u16; 4] {
    DRIVES.map(|id| bench.controlword(id).expect("a set-point"))
}

#[test]
fn a_robot_whose_drives_are_homed_needs_only_the_last_stage() {
    let mut bench = Bench::new(&Settings::default());
    bench.run(200);
    let mut states = vec![state(&mut bench)];
    bench.request(Request::Arm);
    for _ in 0..400 {
        let state = state(&mut bench);
        if states.last() != Some(&state) {
            states.push(state);
        }
    }
    assert_eq!(states, [State::Ready, State::Starting(3), State::Armed]);
}

#[test]
fn drives_that_are_not_homed_start_in_every_stage_one_after_the_other() {
    let mut bench = Bench::new(&Settings::default());
    bench.homed = [true, true, false, false];
    bench.run(200);
    let mut states = vec![state(&mut bench)];
    bench.request(Request::Arm);
    for _ in 0..1_000 {
        let state = state(&mut bench);
        if states.last() != Some(&state) {
            states.push(state);
        }
    }
    let stages = (0..4).map(State::Starting);
    let expected = [State::Ready].into_iter().chain(stages);
    assert!(
        expected.chain([State::Armed]).eq(states.iter().copied()),
        "{states:?}"
    );
}

/// Somebody turns the joint by hand while the drives are off. Its position has 2^-32 turn.
#[test]
fn an_armed_robot_keeps_the_posture_that_it_had_when_it_was_disarmed() {
    const BY_HAND: i32 = 300_000_000;
    let mut bench = Bench::new(&Settings::default());
    bench.run(200);
    bench.joint_held = Some(BY_HAND);
    bench.run(100);
    bench.request(Request::Arm);
    for _ in 0..400 {
        bench.tick();
        if matches!(state(&mut bench), State::Starting(_) | State::Armed) {
            let target = bench.position_set_point(JOINT).expect("a set-point").target;
            assert!(target.abs_diff(BY_HAND) < 1_000, "{target}");
        }
    }
}

/// A load turns the joint while the drives start.
#[test]
fn a_joint_that_yields_while_the_drives_start_keeps_its_set_point() {
    let mut bench = starting();
    let target = |bench: &Bench| bench.position_set_point(JOINT).expect("a set-point").target;
    let before = target(&bench);
    bench.joint_held = Some(300_000_000);
    bench.run(200);
    assert!(matches!(state(&mut bench), State::Starting(_)));
    assert_eq!(target(&bench), before);
}

/// The heartbeat of the drive and its motion come, and it has answered the request for its scale.
#[test]
fn a_robot_is_not_armed_before_every_drive_has_sent_its_status() {
    let mut bench = Bench::new(&Settings::default());
    bench.silent = Some(3);
    bench.request(Request::Stop);
    for tick in 0..1_000 {
        if tick == 300 {
            bench.request(Request::Arm);
        }
        if bench.next_is(50_000) {
            bench.extra.extend(Frame::new(0x703, &[5]));
        }
        if bench.next_is(4_000) {
            let motion = DriveMotion::default().frame(transmit(1), 3);
            bench.extra.push(motion);
        }
        let outputs = bench.tick();
        assert!(outputs.state.state <= State::Ready.code(), "{tick}");
    }
    assert_eq!(state(&mut bench), State::Ready);
    bench.silent = None;
    bench.run(1_000);
    assert_eq!(state(&mut bench), State::Armed);
}

#[test]
fn a_refused_robot_starts_again_only_after_a_new_request() {
    let changes = [(Setting::StopMargin, 95_000)];
    let mut bench = Bench::with(&changes);
    assert!(bench.guard.telemetry().refusal.is_some());
    for _ in 0..1_000 {
        assert_eq!(state(&mut bench), State::Ready);
    }
    bench.request(Request::Stop);
    bench.run(10);
    assert!(bench.guard.telemetry().refusal.is_some());
    bench.request(Request::Arm);
    let starting = (0..40).find_map(|_| {
        let state = State::from_code(bench.tick().state.state);
        matches!(state, Some(State::Starting(_))).then(|| bench.guard.telemetry().refusal)
    });
    assert_eq!(starting, Some(None), "the new start is not refused yet");
}

/// The operator resets in the tick after the fault, before the next SYNC.
#[test]
fn a_reset_before_the_robot_is_held_is_no_new_request_to_arm() {
    let mut bench = Bench::armed();
    while !bench.now_us.is_multiple_of(4_000) {
        bench.tick();
    }
    let code = Fault::Blocked.code();
    bench.extra.push(emergency(Emergency { node: 3, code }));
    bench.tick();
    bench.request(Request::Reset);
    bench.run(3);
    bench.request(Request::Arm);
    bench.run(1_000);
    assert_eq!(state(&mut bench), State::Ready);
    bench.request(Request::Stop);
    bench.run(10);
    bench.request(Request::Arm);
    bench.run(1_000);
    assert_eq!(state(&mut bench), State::Armed);
}

#[test]
fn motors_off_opens_every_bridge_in_every_state() {
    for make in [starting, Bench::armed] {
        let mut bench = make();
        bench.request(Request::Disarm);
        assert_eq!(state(&mut bench), State::Ready);
        assert_eq!(words(&bench), [controlword::DISABLE_VOLTAGE; 4]);
    }
}

#[test]
fn a_stage_goes_on_only_while_the_operator_requests_it_and_attends() {
    for reason in ["stop", "silence", "emergency stop", "override"] {
        let mut bench = starting();
        match reason {
            "stop" => bench.request(Request::Stop),
            "override" => bench.request(Request::Override),
            "silence" => bench.command = None,
            _ => bench.emergency_stop = true,
        }
        bench.run(400);
        assert_eq!(words(&bench), [controlword::QUICK_STOP; 4], "{reason}");
        bench.aligns_until_us = 0;
        bench.run(1_000);
        let stopped = state(&mut bench);
        assert!(
            matches!(stopped, State::Starting(_)),
            "{reason}: {stopped:?}"
        );
    }
}

#[test]
fn an_emergency_stop_before_arming_prevents_it_until_a_reset() {
    let mut bench = Bench::new(&Settings::default());
    bench.run(200);
    bench.emergency_stop = true;
    bench.run(20);
    bench.emergency_stop = false;
    bench.request(Request::Arm);
    let outputs = bench.run(1_000);
    assert_eq!(verdict(&outputs), Some(Verdict::EmergencyStopped));
    assert_eq!(state(&mut bench), State::Ready);
    bench.request(Request::Reset);
    let outputs = bench.run(100);
    assert_eq!(verdict(&outputs), Some(Verdict::Passed));
    bench.request(Request::Arm);
    bench.run(1_000);
    assert_eq!(state(&mut bench), State::Armed);
}

#[test]
fn the_start_command_goes_out_when_all_drives_are_there_and_again_for_one_that_waits() {
    let starts = |bench: &mut Bench, ticks: u64| {
        (0..ticks)
            .filter(|_| {
                let outputs = bench.tick();
                outputs.frames.contains(&nmt(NmtCommand::Start, 0))
            })
            .count()
    };
    let mut bench = Bench::new(&Settings::default());
    bench.silent = Some(5);
    assert_eq!(starts(&mut bench, 400), 0, "a drive is missing");
    bench.silent = None;
    assert_eq!(starts(&mut bench, 400), 1);
    // One heartbeat of a node that is pre-operational.
    bench.heartbeats[1] = 0x7f;
    assert_eq!(starts(&mut bench, 54), 1);
    bench.heartbeats[1] = 5;
    bench.request(Request::Arm);
    bench.run(1_000);
    assert_eq!(state(&mut bench), State::Armed);
    bench.heartbeats[1] = 0x7f;
    assert_eq!(starts(&mut bench, 50), 0, "not while the robot drives");
}

/// The first readings come with the request to arm, and show 70 degrees for 60 ms: a
/// blow, or a chip that has just started.
#[test]
fn first_readings_that_are_wrong_do_not_trip_the_guard_as_soon_as_it_is_armed() {
    let mut bench = Bench::new(&Settings::default());
    bench.body = None;
    bench.run(200);
    bench.body = Some(standing(1.2));
    bench.request(Request::Arm);
    bench.run(60);
    bench.body = Some(standing(0.0));
    let tripped = (0..1_800).any(|_| {
        let verdict = verdict(&bench.tick());
        matches!(verdict, Some(Verdict::Tripped(_)))
    });
    assert!(!tripped);
    assert_eq!(state(&mut bench), State::Armed);
}
