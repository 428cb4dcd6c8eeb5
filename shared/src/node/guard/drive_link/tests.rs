//! Tests of one drive as the guard knows it, frame by frame.

use super::*;
use crate::bus::network::{Emergency, emergency};

const ID: u8 = 3;

/// A drive of default settings (SYNC every 4 ms), and its state.
fn drive() -> (Drive, DriveState) {
    let scale = Scale::Turning { bits: 16 };
    let drive = Drive::new(ID, true, scale, &Settings::default());
    (drive, DriveState::default())
}

fn status(statusword: u16) -> Frame {
    let status = DriveStatus {
        statusword,
        torque: 250,
        ..DriveStatus::default()
    };
    status.frame(transmit(2), ID)
}

/// Heartbeat of CiA 301 with the code of a network state.
fn heartbeat(code: u8) -> Frame {
    Frame::new(0x700 + u16::from(ID), &[code]).expect("a frame")
}

fn motion() -> Frame {
    DriveMotion::default().frame(transmit(1), ID)
}

fn set_point(frame: &Frame) -> PositionSetPoint {
    PositionSetPoint::from_frame(frame, receive(1), ID).expect("a set-point with a position")
}

#[test]
fn a_status_gives_torque_homing_and_operation() {
    for state in [State::SwitchedOn, State::OperationEnabled] {
        for homed in [false, true] {
            let (mut drive, mut known) = drive();
            let bits = if homed { status::HOMED } else { 0 };
            let others = status::LIMIT_ACTIVE | status::TARGET_REACHED;
            drive.receive(
                &status(state.statusword() | bits | others),
                &mut known,
                1_000,
            );
            assert_eq!(known.homed, homed);
            assert_eq!(known.enabled, state == State::OperationEnabled);
            assert!((known.torque - 2.5).abs() < 1e-6, "{} N m", known.torque);
        }
    }
}

#[test]
fn nothing_is_known_of_a_drive_before_its_first_frames() {
    let (mut drive, mut known) = drive();
    assert!(!drive.seen() && !drive.has_status() && drive.state().is_none());
    drive.receive(&status(0x0240), &mut known, 1_000);
    assert!(!drive.seen() && drive.has_status());
    drive.receive(&heartbeat(5), &mut known, 1_000);
    assert!(drive.seen() && !drive.take_start() && !drive.check_restart(true));
}

#[test]
fn a_drive_that_exchanges_no_process_data_gets_one_start_command() {
    // Boot-up, stopped, pre-operational.
    for network in [0, 4, 0x7f] {
        let (mut drive, mut known) = drive();
        drive.receive(&heartbeat(network), &mut known, 1_000);
        // A later heartbeat does not hide it.
        drive.receive(&heartbeat(5), &mut known, 2_000);
        assert!(drive.take_start(), "{network:?}");
        assert!(!drive.take_start(), "{network:?}");
    }
}

#[test]
fn a_restart_counts_until_the_robot_does_not_drive() {
    let (mut drive, mut known) = drive();
    drive.receive(&status(0x0240), &mut known, 1_000);
    drive.receive(&heartbeat(0), &mut known, 2_000);
    assert!(!drive.has_status());
    assert!(drive.check_restart(true) && drive.check_restart(true));
    assert!(drive.check_restart(false) && !drive.check_restart(false));
}

/// The timeout is 60 ms, 15 periods of 4 ms.
#[test]
fn motion_and_status_count_for_60_ms_while_the_robot_drives() {
    for (motion_us, status_us) in [(0, 50_000), (50_000, 0)] {
        let (mut drive, mut known) = drive();
        let operating = status(State::SwitchedOn.statusword());
        for now_us in [0, 50_000] {
            if motion_us == now_us {
                drive.receive(&motion(), &mut known, now_us);
            }
            if status_us == now_us {
                drive.receive(&operating, &mut known, now_us);
            }
        }
        drive.receive(&heartbeat(5), &mut known, 50_000);
        assert_eq!(drive.fault(&known, 60_000, true), None);
        assert_eq!(drive.fault(&known, 60_001, false), None);
        let lost = drive.fault(&known, 60_001, true).map(|report| report.code);
        assert_eq!(lost, Some(Fault::NodeLost.code()));
        let later = drive.fault(&known, 90_000, true).map(|report| report.code);
        assert_eq!(later, Some(Fault::NodeLost.code()));
    }
}

/// The time is 200 ms.
#[test]
fn a_drive_has_200_ms_to_reach_the_commanded_state() {
    for (goal, state) in [
        (Goal::Off, State::OperationEnabled),
        (Goal::Off, State::QuickStopActive),
        (Goal::Hold, State::OperationEnabled),
        (Goal::Home, State::SwitchedOn),
        (Goal::Home, State::QuickStopActive),
    ] {
        let (mut drive, mut known) = drive();
        // Another duty before, so that the time starts with the command.
        let other = if goal == Goal::Hold {
            Goal::Off
        } else {
            Goal::Hold
        };
        drive.command(other, false, 0);
        drive.command(goal, false, 300_000);
        drive.receive(&status(state.statusword()), &mut known, 300_000);
        assert!(!drive.deviates(500_000), "{goal:?} {state:?}");
        assert!(drive.deviates(500_001), "{goal:?} {state:?}");
        assert!(drive.deviates(900_000), "{goal:?} {state:?}");
    }
}

#[test]
fn a_drive_without_a_status_deviates_only_if_it_shall_operate() {
    for (goal, deviates) in [(Goal::Off, false), (Goal::Hold, false), (Goal::Home, true)] {
        let (mut drive, _) = drive();
        drive.command(goal, false, 0);
        assert_eq!(drive.deviates(1_000_000), deviates, "{goal:?}");
    }
}

#[test]
fn only_a_drive_with_a_fault_is_reset_and_a_reset_under_way_goes_on() {
    let (mut drive, mut known) = drive();
    drive.receive(&status(State::SwitchedOn.statusword()), &mut known, 0);
    drive.begin_reset();
    assert!(!drive.resets());
    drive.receive(&status(State::Fault.statusword()), &mut known, 0);
    drive.begin_reset();
    // The bit is high in 4 of the 12 commands, whatever else is requested meanwhile.
    let high: [bool; 13] = core::array::from_fn(|_| {
        let word = set_point(&drive.command(Goal::Hold, false, 0)).controlword;
        if drive.resets() {
            drive.begin_reset();
        }
        word & CONTROL_FAULT_RESET != 0
    });
    assert_eq!(high.iter().filter(|high| **high).count(), 4);
    assert!(!high[0] && !high[11] && !high[12]);
    assert!(!drive.resets());
    let frame = emergency(Emergency {
        node: ID,
        code: Fault::Blocked.code(),
    });
    let (mut drive, mut known) = self::drive();
    drive.receive(&frame, &mut known, 0);
    drive.begin_reset();
    assert!(drive.resets() && drive.error_code() == 0);
}

#[test]
fn a_drive_starts_homing_in_operation_unless_it_is_homed() {
    for state in [State::SwitchedOn, State::OperationEnabled] {
        for (goal, homed) in [
            (Goal::Home, false),
            (Goal::Home, true),
            (Goal::Belt(0.0), false),
        ] {
            let (mut drive, mut known) = drive();
            drive.receive(&status(state.statusword()), &mut known, 0);
            let sent = set_point(&drive.command(goal, homed, 0));
            let starts = state == State::OperationEnabled && goal == Goal::Home && !homed;
            assert_eq!(sent.controlword & CONTROL_START != 0, starts, "{goal:?}");
            let low = sent.controlword & !CONTROL_START;
            assert_eq!(low, controlword::ENABLE_OPERATION, "{goal:?} {state:?}");
            let mode = if goal == Goal::Belt(0.0) {
                mode::TAUT
            } else {
                mode::HOMING
            };
            assert_eq!(sent.mode, mode);
        }
    }
}

#[test]
fn a_drive_that_left_operation_by_itself_is_not_enabled_again() {
    let (mut drive, mut known) = drive();
    let mut word = |state: State| {
        drive.receive(&status(state.statusword()), &mut known, 0);
        set_point(&drive.command(Goal::Belt(0.0), true, 0)).controlword
    };
    assert_eq!(word(State::SwitchOnDisabled), controlword::SHUTDOWN);
    assert_eq!(word(State::SwitchedOn), controlword::ENABLE_OPERATION);
    assert_eq!(word(State::OperationEnabled), controlword::ENABLE_OPERATION);
    assert_eq!(word(State::SwitchedOn), controlword::QUICK_STOP);
    assert_eq!(word(State::QuickStopActive), controlword::QUICK_STOP);
}

/// CiA 301: overrun, error passive, recovered from bus-off, PDO with too few bytes.
#[test]
fn what_a_drive_remarks_upon_its_bus_is_no_fault_and_hides_none() {
    for remark in [0x8110, 0x8120, 0x8140, 0x8210] {
        let (mut drive, mut known) = drive();
        let mut send = |drive: &mut Drive, code| {
            let frame = emergency(Emergency { node: ID, code });
            drive.receive(&frame, &mut known, 0);
        };
        send(&mut drive, remark);
        assert_eq!(drive.error_code(), 0, "{remark:#x}");
        send(&mut drive, 0x2310);
        send(&mut drive, remark);
        assert_eq!(drive.error_code(), 0x2310, "{remark:#x}");
    }
}
