//! Tests with drives that fail, fall silent, restart or count in other units.

use super::bench::{Bench, JOINT, standing};
use tautrack::bus::cia402::{CONTROL_FAULT_RESET, State as DriveState, controlword};
use tautrack::bus::network::{Emergency, NmtCommand, emergency, nmt, sync};
use tautrack::bus::pdo::{
    DriveMotion, DriveStatus, Payload, PositionSetPoint, Request, receive, transmit,
};
use tautrack::can::Frame;
use tautrack::faults::Fault;
use tautrack::node::guard::{Guard, Inputs, MAX_SENT, POSITION_SCALE, State};
use tautrack::robots::hylos::Hylos;
use tautrack::robots::{Body, MAX_DRIVES};
use tautrack::settings::Settings;

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
fn the_guard_waits_for_drives_that_show_an_alignment() {
    for shown in [true, false] {
        let mut bench = Bench::new(&Settings::default());
        bench.run(200);
        bench.aligns_until_us = bench.now_us + 1_500_000;
        if !shown {
            bench.aligning = 0;
        }
        bench.request(Request::Arm);
        let outputs = bench.run(1_400);
        let state = State::from_code(outputs.state.state);
        if shown {
            assert!(matches!(state, Some(State::Starting(_))), "{state:?}");
            let outputs = bench.run(1_000);
            assert_eq!(State::from_code(outputs.state.state), Some(State::Armed));
        } else {
            assert_eq!(state, Some(State::Held));
            assert_eq!(outputs.state.fault_code, Fault::UnexpectedState.code());
        }
    }
}

#[test]
fn a_reset_is_a_pulse_and_each_reset_has_its_edge() {
    let mut bench = Bench::armed();
    // The supply voltage is too low, and stays so for two seconds.
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
    // The supply voltage is back. The next reset clears the fault.
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
    // `position_bits` of the joint, changed at the axle only.
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

/// The restart comes at each phase of the SYNC period.
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
            // The other frames of the drive still come.
            if bench.next_is(50_000) {
                bench.extra.extend(Frame::new(0x703, &[5]));
            }
            if !bench.next_is(4_000) {
                bench.tick();
                continue;
            }
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

/// Hylos has the largest number of drives. All of them restart at once, because their supply was
/// interrupted.
#[test]
fn a_guard_sends_every_request_and_every_set_point_in_one_tick() {
    let settings = Settings::default();
    let mut guard = Guard::<Hylos>::new(&settings).expect("the default robot is good");
    let ids = Hylos::drive_ids(&settings);
    assert_eq!(ids.len(), MAX_DRIVES);
    let mut now_us = 0;
    let mut tick = |frames: &[Frame]| {
        now_us += 1_000;
        let inputs = Inputs {
            now_us,
            body: Some(standing(0.0)),
            operator: None,
            emergency_stop: false,
            frames,
            serial: &[],
        };
        guard.tick(&inputs).clone()
    };
    tick(&[]);
    let [low, high] = POSITION_SCALE.to_le_bytes();
    let mut frames = Vec::new();
    for (drive, id) in ids.iter().map(|id| u16::from(*id)).enumerate() {
        let [a, b] = Hylos::scale(drive).code().to_le_bytes();
        frames.extend(Frame::new(0x700 + id, &[5]));
        frames.extend(Frame::new(0x580 + id, &[0x4b, low, high, 0, a, b, 0, 0]));
    }
    tick(&frames);
    for _ in 0..8 {
        tick(&[]);
    }
    assert_eq!(tick(&[]).state.state, State::Ready.code());
    let boot_up = ids
        .iter()
        .map(|id| Frame::new(0x700 + u16::from(*id), &[0]));
    let mut outputs = tick(&boot_up.map(Option::unwrap).collect::<Vec<_>>());
    while outputs.frames.first() != Some(&sync()) {
        outputs = tick(&[]);
    }
    assert_eq!(outputs.frames[1], nmt(NmtCommand::Start, 0));
    let with = |function: u16, id: &u8| {
        let id = function + u16::from(*id);
        outputs.frames.iter().any(|frame| frame.id() == id)
    };
    for id in &ids {
        assert!(with(0x600, id), "request to {id}");
        assert!(with(0x200, id) || with(0x300, id), "set-point of {id}");
    }
    assert_eq!(outputs.frames.len(), MAX_SENT);
}
