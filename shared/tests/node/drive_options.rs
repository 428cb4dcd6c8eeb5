//! Tests of the option codes, windows and handshakes of CiA 402, and of torque mode, on an axle
//! with the motor model.

use super::drive_bench::{Bench, MOTOR, turns};
use crate::random::Random;
use std::f64::consts::TAU;
use tautrack::bus::cia402::{
    CHANGE_IMMEDIATELY, CONTROL_FAULT_RESET, CONTROL_HALT, CONTROL_START, RELATIVE, State,
    controlword, mode, status,
};
use tautrack::bus::drive_parameters::DriveParameters;
use tautrack::motor::model::MotorModel;
use tautrack::node::axle::{ActiveLimit, BridgeDemand};
use tautrack::sensors::Switches;
use tautrack::settings::Setting;

const OPERATION: u16 = controlword::ENABLE_OPERATION;
/// Velocity of the running axle, 1e-6 rad/s.
const SPEED: i32 = 3_000_000;

/// An axle that turns with 3 rad/s. A quick stop decelerates with 60 rad/s^2, other stops with 20.
fn running() -> Bench {
    let mut bench = Bench::new(&[(Setting::QuickStopDeceleration, 60_000)], MOTOR);
    bench.enable(mode::CYCLIC_VELOCITY, SPEED);
    bench.run(400);
    assert!((bench.velocity() - 3.0).abs() < 0.1, "{}", bench.velocity());
    bench
}

/// What the drive does after a command.
#[derive(Clone, Copy, Debug)]
enum Then {
    /// The bridge is off in the next set-point.
    Off(State),
    /// It ramps for this time, ms; then the bridge goes off.
    RampsOff(usize, State),
    /// It ramps for this time, ms, and holds in this state.
    RampsAndHolds(usize, State),
}

/// Ramps from 3 rad/s at 20 and at 60 rad/s^2, ms.
const SLOW: usize = 150;
const QUICK: usize = 50;

#[test]
fn every_option_code_stops_the_axle_as_cia_402_says() {
    use State::{OperationEnabled, QuickStopActive, ReadyToSwitchOn, SwitchOnDisabled, SwitchedOn};
    use Then::{Off, RampsAndHolds, RampsOff};
    type Write = fn(&mut DriveParameters);
    let halt = OPERATION | CONTROL_HALT;
    let cases: &[(u16, Write, Then)] = &[
        (0x02, |p| p.quick_stop = 0, Off(SwitchOnDisabled)),
        (0x02, |p| p.quick_stop = 1, RampsOff(SLOW, SwitchOnDisabled)),
        (
            0x02,
            |p| p.quick_stop = 2,
            RampsOff(QUICK, SwitchOnDisabled),
        ),
        (
            0x02,
            |p| p.quick_stop = 5,
            RampsAndHolds(SLOW, QuickStopActive),
        ),
        (
            0x02,
            |p| p.quick_stop = 6,
            RampsAndHolds(QUICK, QuickStopActive),
        ),
        (0x06, |p| p.shutdown = 0, Off(ReadyToSwitchOn)),
        (0x06, |p| p.shutdown = 1, RampsOff(SLOW, ReadyToSwitchOn)),
        (0x07, |p| p.disable_operation = 0, Off(SwitchedOn)),
        (
            0x07,
            |p| p.disable_operation = 1,
            RampsOff(SLOW, SwitchedOn),
        ),
        (halt, |p| p.halt = 1, RampsAndHolds(SLOW, OperationEnabled)),
        (halt, |p| p.halt = 2, RampsAndHolds(QUICK, OperationEnabled)),
        (
            0x00,
            |p| (p.quick_stop, p.shutdown) = (1, 1),
            Off(SwitchOnDisabled),
        ),
    ];
    for (row, &(word, write, then)) in cases.iter().enumerate() {
        let mut bench = running();
        bench.set(write);
        bench.word = word;
        let ramp = match then {
            Off(state) => {
                bench.run(4);
                assert_eq!(bench.outputs.bridge, BridgeDemand::Off, "row {row}");
                assert_eq!(bench.state(), state, "row {row}");
                continue;
            }
            RampsOff(ramp, state) => {
                let took = bench.until_off().expect("off");
                assert_eq!(bench.state(), state, "row {row}");
                assert!(took >= ramp && took < ramp + 60, "row {row}: {took} ms");
                assert!(bench.velocity().abs() < 0.15, "row {row}");
                continue;
            }
            RampsAndHolds(ramp, state) => {
                bench.run(4);
                assert_eq!(bench.state(), state, "row {row}");
                ramp
            }
        };
        bench.run(ramp / 2);
        assert!(bench.velocity() > 0.9, "row {row}: {}", bench.velocity());
        bench.run(ramp / 2 + 60);
        assert!(bench.velocity().abs() < 0.1, "row {row}");
        let held = bench.angle();
        bench.load = 5.0;
        bench.run(500);
        assert!((bench.angle() - held).abs() < 0.02, "row {row}");
        assert!(
            matches!(bench.outputs.bridge, BridgeDemand::Current(_)),
            "row {row}"
        );
    }
}

#[test]
fn a_ramp_to_standstill_ends_by_a_new_enable_operation_or_disable_voltage() {
    let mut bench = running();
    bench.set(|p| (p.shutdown, p.quick_stop) = (1, 2));
    bench.send(controlword::SHUTDOWN, 40);
    bench.send(OPERATION, 400);
    assert_eq!(bench.state(), State::OperationEnabled);
    assert!((bench.velocity() - 3.0).abs() < 0.1, "{}", bench.velocity());
    bench.send(controlword::SHUTDOWN, 40);
    bench.send(controlword::DISABLE_VOLTAGE, 4);
    assert_eq!(bench.state(), State::SwitchOnDisabled);
    assert_eq!(bench.outputs.bridge, BridgeDemand::Off);
    // A quick stop that ends in "switch on disabled" cannot be cancelled.
    bench.enable(mode::CYCLIC_VELOCITY, SPEED);
    bench.run(400);
    bench.send(controlword::QUICK_STOP, 8);
    bench.send(OPERATION, 200);
    assert_eq!(bench.outputs.bridge, BridgeDemand::Off);
}

#[test]
fn the_fault_reaction_code_never_weakens_the_table_of_faults() {
    for (code, holds) in [(0, false), (1, true), (2, true)] {
        let mut bench = running();
        // The guard's heartbeat ends bench mode and restores the codes; then both fall silent.
        bench.guard = true;
        bench.send(controlword::DISABLE_VOLTAGE, 300);
        bench.set(|p| p.fault_reaction = code);
        bench.enable(mode::CYCLIC_VELOCITY, SPEED);
        bench.run(300);
        bench.guard = false;
        bench.run(200);
        assert_ne!(bench.outputs.status.error_code, 0);
        assert_eq!(
            matches!(bench.outputs.bridge, BridgeDemand::Current(_)),
            holds,
            "{code}"
        );
        let state = if holds {
            State::QuickStopActive
        } else {
            State::Fault
        };
        assert_eq!(bench.state(), state);
    }
    // A fault that opens the bridge, or shorts the windings, does so with every code.
    for code in 0..3 {
        let mut bench = running();
        bench.set(|p| p.fault_reaction = code);
        bench.motor.freeze_sensor(true);
        bench.load = 24.0;
        bench.run(200);
        assert_eq!(bench.state(), State::Fault, "{code}");
        assert!(
            !matches!(bench.outputs.bridge, BridgeDemand::Current(_)),
            "{code}"
        );
    }
}

/// The axle holds because the guard falls silent. The guard comes back, and the operator resets.
#[test]
fn a_fault_that_holds_ramps_by_its_code_and_its_reset_leaves_the_axle_holding() {
    for (code, ramp) in [(1, SLOW), (2, QUICK)] {
        let mut bench = running();
        bench.guard = true;
        bench.send(controlword::DISABLE_VOLTAGE, 300);
        bench.set(|p| p.fault_reaction = code);
        bench.enable(mode::CYCLIC_VELOCITY, SPEED);
        bench.run(400);
        bench.guard = false;
        while bench.state() == State::OperationEnabled {
            bench.tick();
        }
        let took = (0..400_usize).find(|_| {
            bench.tick();
            bench.velocity() < 0.1
        });
        let took = took.expect("a stop");
        assert!(took.abs_diff(ramp) < 30, "{code}: {took} ms");

        bench.guard = true;
        bench.send(controlword::QUICK_STOP, 100);
        assert_ne!(bench.outputs.status.error_code, 0);
        bench.send(controlword::QUICK_STOP | CONTROL_FAULT_RESET, 100);
        assert_eq!(bench.outputs.status.error_code, 0);
        assert_eq!(bench.state(), State::QuickStopActive);
        assert!(matches!(bench.outputs.bridge, BridgeDemand::Current(_)));
    }
}

/// The load is as strong as the motor with its largest current (10 A, 24 N m) and the friction. So
/// the shaft goes on turning after the ramp, which takes one control period.
#[test]
fn a_shaft_that_a_load_keeps_turning_loses_power_500_ms_after_the_ramp() {
    let mut bench = Bench::new(&[(Setting::QuickStopDeceleration, 1_000_000)], MOTOR);
    bench.set(|p| p.quick_stop = 2);
    bench.enable(mode::CYCLIC_VELOCITY, -500_000);
    bench.run(400);
    bench.word = controlword::QUICK_STOP;
    while bench.state() == State::OperationEnabled {
        bench.tick();
    }
    bench.load = 24.3;
    let more = bench.until_off().expect("off");
    assert!(bench.velocity().abs() > 0.1, "{}", bench.velocity());
    assert_eq!(bench.outputs.status.error_code, 0);
    assert_eq!(more + 1, 500);
}

#[test]
fn a_halt_lasts_until_its_bit_falls_in_every_mode() {
    for (mode, target) in [
        (mode::CYCLIC_VELOCITY, SPEED),
        (mode::PROFILE_VELOCITY, SPEED),
        (mode::CYCLIC_TORQUE, 120),
        (mode::PROFILE_POSITION, turns(40.0)),
    ] {
        let mut bench = Bench::new(&[], MOTOR);
        bench.enable(mode, target);
        bench.send(OPERATION | CONTROL_START, 250);
        assert!(bench.velocity() > 1.0, "{mode}: {}", bench.velocity());
        bench.send(OPERATION | CONTROL_HALT, 600);
        assert!(
            bench.velocity().abs() < 0.05,
            "{mode}: {}",
            bench.velocity()
        );
        assert_ne!(bench.status() & status::TARGET_REACHED, 0, "{mode}");
        bench.send(OPERATION, 300);
        assert!(bench.velocity() > 1.0, "{mode}: {}", bench.velocity());
    }
}

#[test]
fn a_torque_is_that_of_the_target_and_rises_with_the_slope() {
    let mut bench = Bench::new(&[], MOTOR);
    bench.set(|p| p.torque_slope = 4_800); // 20 A/s
    bench.enable(mode::CYCLIC_TORQUE, 0);
    bench.load = 4.0;
    bench.target = 480; // 4.8 N m
    let mut last = 0.0;
    for _ in 0..100 {
        bench.tick();
        let BridgeDemand::Current(current) = bench.outputs.bridge else {
            panic!("off");
        };
        assert!(
            (0.0..0.0201).contains(&(current - last)),
            "{last} {current}"
        );
        last = current;
    }
    assert!((last - 2.0).abs() < 0.1, "{last} A after 100 ms");
    let torque = f64::from(bench.outputs.status.torque);
    assert!((torque - 480.0).abs() < 40.0, "{torque}");
}

#[test]
fn no_torque_exceeds_the_velocity_limit_or_the_current_limit() {
    for target in [24_000, -24_000, i32::from(i16::MAX), 300, -300] {
        let mut bench = Bench::new(&[], MOTOR);
        bench.enable(mode::CYCLIC_TORQUE, target);
        for _ in 0..3_000 {
            bench.tick();
            let BridgeDemand::Current(current) = bench.outputs.bridge else {
                panic!("{:?}", bench.outputs);
            };
            assert!(current.abs() <= 10.0);
            assert!(bench.velocity().abs() < 6.3, "{}", bench.velocity());
        }
        assert!(bench.velocity().abs() > 4.0, "{}", bench.velocity());
        assert_eq!(bench.outputs.active_limit, ActiveLimit::VelocityOrCurrent);
    }
}

#[test]
fn a_velocity_loop_takes_over_from_a_torque_without_a_jump_while_any_limit_acts() {
    let mut random = Random(1);
    let mut within =
        |low: i32, high: i32| low + ((random.next() + 1.0) * 0.5 * f64::from(high - low)) as i32;
    let (mut limited, mut largest) = (0, 0.0_f32);
    for case in 0..200 {
        // The shaft is held.
        let held = MotorModel {
            friction_torque: 30.0,
            ..MOTOR
        };
        let limits = [
            (Setting::CurrentSlope, within(20, 200)),
            (Setting::PowerLimit, within(5, 60)),
        ];
        let mut bench = Bench::new(&limits, held);
        let current = |bench: &Bench| match bench.outputs.bridge {
            BridgeDemand::Current(current) => current,
            _ => panic!("{case}: {:?}", bench.outputs),
        };
        bench.enable(mode::CYCLIC_TORQUE, 0);
        for _ in 0..3 {
            bench.target = within(-2_000, 2_000);
            bench.run(within(5, 100) as usize);
        }
        (bench.mode, bench.target) = (mode::CYCLIC_VELOCITY, 0);
        let mut last = current(&bench);
        let mut limit = ActiveLimit::None;
        for _ in 0..50 {
            bench.tick();
            if bench.outputs.mode == mode::CYCLIC_TORQUE {
                (last, limit) = (current(&bench), bench.outputs.active_limit);
            }
            largest = largest.max((current(&bench) - last).abs());
        }
        limited += u32::from(limit != ActiveLimit::None);
    }
    println!("at most {largest} A off; a limit acted in {limited} of 200 cases");
    assert!(limited > 50, "{limited}");
    assert!(largest < 0.05, "{largest} A");
}

#[test]
fn a_torque_ends_at_a_limit_switch_and_at_the_end_of_travel() {
    let mut bench = Bench::new(&[], MOTOR);
    bench.switches = |angle| Switches {
        positive_limit: angle >= 1.0,
        ..Switches::default()
    };
    bench.enable(mode::CYCLIC_TORQUE, 600);
    bench.run(2_000);
    assert!((bench.angle() - 1.0).abs() < 0.05, "{}", bench.angle());
    assert_eq!(bench.outputs.active_limit, ActiveLimit::Switch);
    bench.target = -200;
    bench.run(500);
    assert!(bench.angle() < 0.9, "{}", bench.angle());

    let mut bench = Bench::new(&[], MOTOR);
    bench.set(|p| p.position_limits = [turns(-1.0), turns(1.0)]);
    bench.enable(mode::CYCLIC_TORQUE, -600);
    bench.run(2_000);
    assert!((bench.angle() + 1.0).abs() < 0.05, "{}", bench.angle());
    assert_eq!(bench.outputs.active_limit, ActiveLimit::Travel);
}

/// Hands over a target in profile position mode.
fn hand_over(bench: &mut Bench, target: f64, bits: u16) {
    bench.target = turns(target);
    bench.send(OPERATION | CONTROL_START | bits, 8);
}

#[test]
fn a_set_point_is_taken_with_its_edge_and_acknowledged() {
    let acknowledged = |bench: &Bench| bench.status() & status::FOLLOWING != 0;
    let reached = |bench: &Bench| bench.status() & status::TARGET_REACHED != 0;
    let mut bench = Bench::new(&[], MOTOR);
    bench.enable(mode::PROFILE_POSITION, turns(2.0));
    bench.run(500);
    assert!(bench.angle().abs() < 0.01, "moved without a set-point");
    assert!(!acknowledged(&bench) && !reached(&bench));

    hand_over(&mut bench, 2.0, 0);
    assert!(acknowledged(&bench) && !reached(&bench));
    bench.send(OPERATION, 8);
    assert!(!acknowledged(&bench), "the buffer is free");
    // The next one waits; a third is not accepted.
    hand_over(&mut bench, 3.0, 0);
    bench.send(OPERATION, 8);
    assert!(acknowledged(&bench), "the buffer is full");
    hand_over(&mut bench, -9.0, 0);
    bench.send(OPERATION, 300);
    let mut stood = false;
    for _ in 0..1_500 {
        bench.tick();
        stood |= (bench.angle() - 2.0).abs() < 0.01 && bench.velocity().abs() < 0.05;
    }
    assert!(stood, "never stood at the first target");
    assert!((bench.angle() - 3.0).abs() < 0.01, "{}", bench.angle());
    assert!(reached(&bench) && !acknowledged(&bench));

    // Relative to the last target, not to the position.
    hand_over(&mut bench, -0.5, RELATIVE);
    assert!(!reached(&bench));
    bench.send(OPERATION, 1_000);
    assert!((bench.angle() - 2.5).abs() < 0.01, "{}", bench.angle());
    // Changed on the way.
    hand_over(&mut bench, 9.0, 0);
    bench.send(OPERATION, 200);
    hand_over(&mut bench, 1.0, CHANGE_IMMEDIATELY);
    bench.send(OPERATION, 2_000);
    assert!((bench.angle() - 1.0).abs() < 0.01, "{}", bench.angle());
}

#[test]
fn targets_that_are_handed_over_in_a_halt_are_reached_one_after_the_other() {
    let mut bench = Bench::new(&[], MOTOR);
    bench.enable(mode::PROFILE_POSITION, 0);
    for target in [2.0, 3.0] {
        hand_over(&mut bench, target, CONTROL_HALT);
        bench.send(OPERATION | CONTROL_HALT, 8);
    }
    bench.word = OPERATION;
    let mut stood = false;
    for _ in 0..2_000 {
        bench.tick();
        stood |= (bench.angle() - 2.0).abs() < 0.01 && bench.velocity().abs() < 0.05;
    }
    assert!(stood, "never stood at the first target");
    assert!((bench.angle() - 3.0).abs() < 0.01, "{}", bench.angle());
}

#[test]
fn an_axle_takes_no_target_before_it_is_homed() {
    let acknowledged = |bench: &Bench| bench.status() & status::FOLLOWING != 0;
    let mut bench = Bench::new(&[(Setting::HomingDirection, 1)], MOTOR);
    bench.set(|p| p.homing_method = 37);
    bench.enable(mode::PROFILE_POSITION, 0);
    hand_over(&mut bench, 1.0, 0);
    assert!(!acknowledged(&bench));
    bench.mode = mode::HOMING;
    bench.send(OPERATION, 8);
    bench.send(OPERATION | CONTROL_START, 8);
    bench.mode = mode::PROFILE_POSITION;
    bench.send(OPERATION, 8);
    hand_over(&mut bench, 1.0, 0);
    assert!(acknowledged(&bench));
}

/// The limits and the guard's targets are in bus units, so that a target is exactly at its limit.
#[test]
fn a_target_at_the_end_of_the_travel_is_not_limited() {
    for (target, limited) in [(1.0, false), (-1.0, false), (1.01, true), (-1.01, true)] {
        let mut bench = Bench::new(&[], MOTOR);
        bench.guard = true;
        bench.run(60);
        bench.set(|p| p.position_limits = [turns(-1.0), turns(1.0)]);
        bench.enable(mode::PROFILE_POSITION, turns(target));
        bench.run(1_000);
        assert!(
            (bench.angle().abs() - 1.0).abs() < 0.01,
            "{}",
            bench.angle()
        );
        let expected = if limited {
            ActiveLimit::Travel
        } else {
            ActiveLimit::None
        };
        assert_eq!(bench.outputs.active_limit, expected, "{target}");
    }
}

#[test]
fn the_guards_targets_need_no_edge() {
    let mut bench = Bench::new(&[], MOTOR);
    bench.guard = true;
    bench.enable(mode::PROFILE_POSITION, turns(1.0));
    bench.run(1_000);
    assert!((bench.angle() - 1.0).abs() < 0.01, "{}", bench.angle());
}

#[test]
fn a_target_ends_at_the_software_position_limits_within_the_travel() {
    let travel = [
        (Setting::PositionMinimum, -2_000),
        (Setting::PositionMaximum, 2_000),
    ];
    // Limits, target, and where the axle ends, rad.
    for (limits, target, end) in [
        ([-1.0, 1.0], 1.5, 1.0),
        ([-1.0, 1.0], -1.5, -1.0),
        ([-9.0, 9.0], 3.0, 2.0),
        ([1.0, -1.0], 1.5, 1.5),
    ] {
        let mut bench = Bench::new(&travel, MOTOR);
        bench.set(|p| p.position_limits = limits.map(turns));
        bench.enable(mode::PROFILE_POSITION, 0);
        hand_over(&mut bench, target, 0);
        bench.send(OPERATION, 1_500);
        assert!(
            (bench.angle() - end).abs() < 0.01,
            "{limits:?} {target}: {}",
            bench.angle()
        );
    }
}

#[test]
fn the_windows_report_what_is_outside_for_their_time() {
    let mut bench = Bench::new(&[], MOTOR);
    bench.set(|p| {
        (p.position_window, p.position_time) = (turns(0.02) as u32, 100);
        (p.following_window, p.following_time) = (turns(0.02) as u32, 30);
    });
    bench.enable(mode::PROFILE_POSITION, 0);
    hand_over(&mut bench, 1.0, 0);
    bench.word = OPERATION;
    let bits = |bench: &Bench| bench.status() & (status::TARGET_REACHED | status::ERROR_OF_MODE);
    let mut within = 0;
    while bits(&bench) & status::TARGET_REACHED == 0 {
        bench.tick();
        within = if (bench.angle() - 1.0).abs() < 0.02 {
            within + 1
        } else {
            0
        };
        assert!(within < 200);
    }
    assert!(within >= 99, "{within} ms within the window");
    assert_eq!(bits(&bench), status::TARGET_REACHED);
    // A load pulls the axle away, for longer than 30 ms.
    bench.load = 20.0;
    let mut outside = 0;
    while bits(&bench) & status::ERROR_OF_MODE == 0 {
        bench.tick();
        outside += usize::from((bench.angle() - 1.0).abs() > 0.02);
        assert!(outside < 40);
    }
    assert!(outside >= 29, "{outside} ms");
    assert_eq!(bits(&bench), status::ERROR_OF_MODE);
}

/// Switches of the bench for homing: the home switch is closed within a range, and both limit
/// switches close beyond 2 rad.
fn switches(home: bool, angle: f64) -> Switches {
    Switches {
        home,
        positive_limit: angle > 2.0,
        negative_limit: angle < -2.0,
    }
}

#[test]
fn every_homing_method_finds_its_edge_from_every_start() {
    type Places = fn(f64) -> Switches;
    let positive: Places = |angle| switches(angle > 0.5, angle);
    let negative: Places = |angle| switches(angle < -0.5, angle);
    let range: Places = |angle| switches((0.5..0.9).contains(&angle), angle);
    // Method, switches, angle of the home position, and angles at which homing starts.
    let cases: &[(i8, Places, f64, &[f64])] = &[
        (17, positive, -2.0, &[0.0, -1.5, -2.1]),
        (18, negative, 2.0, &[0.0, 1.5, 2.1]),
        (19, positive, 0.5, &[0.0, 1.0]),
        (20, positive, 0.5, &[0.0, 1.0]),
        (21, negative, -0.5, &[0.0, -1.0]),
        (22, negative, -0.5, &[0.0, -1.0]),
        (23, range, 0.5, &[0.0, 0.7, 1.5]),
        (24, range, 0.5, &[0.0, 0.7, 1.5]),
    ];
    for &(method, places, home, starts) in cases {
        for &start in starts {
            let mut bench = Bench::new(&[(Setting::HomingSpeed, 1_000)], MOTOR);
            bench.enable(mode::PROFILE_POSITION, 0);
            hand_over(&mut bench, start, 0);
            bench.send(OPERATION, 2_500);
            bench.switches = places;
            bench.set(|p| p.homing_method = method);
            bench.mode = mode::HOMING;
            bench.send(OPERATION, 8);
            bench.send(OPERATION | CONTROL_START, 12_000);
            let bits = status::TARGET_REACHED | status::FOLLOWING | status::ERROR_OF_MODE;
            let done = status::TARGET_REACHED | status::FOLLOWING;
            assert_eq!(bench.status() & bits, done, "{method} from {start}");
            let position = f64::from(bench.outputs.motion.position) / 65_536.0 * TAU;
            let error = position - (bench.angle() - home);
            assert!(error.abs() < 1.5e-3, "{method} from {start}: {error} rad");
        }
    }
}

/// The axle passes the switch while it decelerates, or stops on it.
#[test]
fn homing_that_begins_in_motion_decelerates_first() {
    for (method, speed) in [
        (19, -6.0),
        (19, 3.0),
        (19, 6.0),
        (20, -3.0),
        (20, 3.0),
        (20, 6.0),
    ] {
        for delay in [150, 300, 400, 500] {
            let mut bench = Bench::new(&[(Setting::HomingSpeed, 1_000)], MOTOR);
            bench.switches = |angle| switches(angle > 0.5, 0.0);
            bench.set(|p| p.homing_method = method);
            bench.enable(mode::CYCLIC_VELOCITY, (speed * 1e6) as i32);
            bench.run(delay);
            bench.mode = mode::HOMING;
            bench.send(OPERATION | CONTROL_START, 12_000);
            let case = format!("{method} at {speed} rad/s for {delay} ms");
            assert!(
                bench.outputs.faults.is_empty(),
                "{case}: {:?}",
                bench.outputs.faults
            );
            let done = status::TARGET_REACHED | status::FOLLOWING;
            let bits = done | status::ERROR_OF_MODE;
            assert_eq!(bench.status() & bits, done, "{case}");
            let position = f64::from(bench.outputs.motion.position) / 65_536.0 * TAU;
            let error = position - (bench.angle() - 0.5);
            assert!(error.abs() < 1.5e-3, "{case}: {error} rad");
        }
    }
}

#[test]
fn method_37_takes_the_present_position() {
    let changes = [
        (Setting::HomingDirection, 1),
        (Setting::HomePosition, 250_000),
    ];
    let mut bench = Bench::new(&changes, MOTOR);
    bench.set(|p| p.homing_method = 37);
    bench.enable(mode::HOMING, 0);
    assert_eq!(bench.status() & status::HOMED, 0);
    bench.send(OPERATION | CONTROL_START, 8);
    assert_ne!(bench.status() & status::HOMED, 0);
    // The position on the bus is rounded down.
    let position = bench.outputs.motion.position;
    assert!((turns(0.25) - position).abs() <= 1, "{position}");
}

#[test]
fn the_direction_in_the_settings_selects_the_method_at_start() {
    for (direction, method) in [(1, 20), (-1, 22), (0, 0)] {
        let bench = Bench::new(&[(Setting::HomingDirection, direction)], MOTOR);
        assert_eq!(bench.axle.parameters().homing_method, method);
    }
}
