//! Tests of the guarantees in docs/nodes.md for axle and screw, each on a bench with a rotor. They
//! run the same ticks as the nodes' programs.
//!
//! This file tests states, modes, stops and limits. `homing`, `command` (who may command an axle),
//! `runaway` and `screw` test the other functions of one drive. `network` connects a guard and all
//! drives of a robot. `stops` and `stop_sequences` test the stops of the guard, and `limits` the
//! frames that it sends for any input.

mod bench;
mod command;
mod feed_forward;
mod homing;
mod limits;
mod network;
mod random;
mod runaway;
mod screw;
mod stop_sequences;
mod stops;

use bench::{Bench, state};
use std::f64::consts::TAU;
use tautrack::bus::cia402::{CONTROL_FAULT_RESET, State, controlword, mode};
use tautrack::faults::Fault;
use tautrack::node::axle::{ActiveLimit, BridgeDemand, Outputs};
use tautrack::sensors::Switches;
use tautrack::settings::Setting;

/// Converts an angle to bus units of an axle's position with 16 fraction bits.
fn turning(radians: f64) -> i32 {
    (radians / TAU * 65_536.0).round() as i32
}

fn code(outputs: &Outputs) -> Option<Fault> {
    Fault::from_code(outputs.status.error_code)
}

/// Asserts that the axle ramps to standstill within `within_ms`, and then holds against 5 N m for
/// two seconds.
fn assert_holds(bench: &mut Bench, fault: Fault, within_ms: usize) {
    let outputs = bench.run(within_ms);
    assert_eq!(code(&outputs), Some(fault));
    assert_eq!(state(&outputs), Some(State::QuickStopActive));
    assert!(
        bench.velocity.abs() < 0.03,
        "still {} rad/s",
        bench.velocity
    );
    let held_at = bench.angle;
    bench.load = 5.0;
    let outputs = bench.run(2_000);
    assert!(matches!(outputs.bridge, BridgeDemand::Current(_)));
    let moved = (bench.angle - held_at).abs();
    assert!(moved < 0.01, "gave way by {moved} rad");
}

/// Time to stop, ms: the ramp from 3 rad/s at 20 rad/s^2 takes 150 ms, and the loops settle to 0.03
/// rad/s in another 150 ms.
const RAMP_MS: usize = 300;

fn running(speed: f64) -> Bench {
    let mut bench = Bench::axle(&[]);
    bench.enable(mode::CYCLIC_VELOCITY, (speed * 1e6) as i32);
    bench.run(400);
    assert!((bench.velocity - speed).abs() < 0.02, "{}", bench.velocity);
    bench
}

#[test]
fn axle_holds_when_set_points_stop() {
    let mut bench = running(3.0);
    bench.set_point = None;
    let before = bench.run(56);
    assert_eq!(code(&before), None, "command_timeout is 60 ms");
    assert_holds(&mut bench, Fault::CommandLost, 10 + RAMP_MS);
}

#[test]
fn axle_holds_when_the_guards_heartbeat_stops_though_set_points_go_on() {
    let mut bench = running(3.0);
    bench.guard_alive = false;
    let before = bench.run(60);
    assert_eq!(code(&before), None, "heartbeat_timeout is 120 ms");
    assert_holds(&mut bench, Fault::GuardLost, 70 + RAMP_MS);
}

#[test]
fn a_stop_is_a_ramp_and_no_jerk() {
    let mut bench = running(3.0);
    bench.command(controlword::QUICK_STOP, 0, 0);
    let mut last = bench.velocity;
    for _ in 0..RAMP_MS {
        bench.tick();
        // The ramp is limited to 20 rad/s^2; the loop that follows it may briefly exceed this a
        // little.
        assert!(
            (bench.velocity - last).abs() < 0.04,
            "{last} {}",
            bench.velocity
        );
        last = bench.velocity;
    }
    assert!(last.abs() < 0.03, "{last}");
}

#[test]
fn a_fault_reset_needs_a_rising_edge_and_does_not_re_enable() {
    let mut bench = running(3.0);
    let target = 3_000_000;
    bench.set_point = None;
    bench.run(500);
    // The master returns and sends the same commands as before: the axle must not move.
    bench.command(controlword::ENABLE_OPERATION, mode::CYCLIC_VELOCITY, target);
    let outputs = bench.run(500);
    assert_eq!(code(&outputs), Some(Fault::CommandLost));
    assert_eq!(state(&outputs), Some(State::QuickStopActive));
    // A reset during this clears the fault; the axle still must not move.
    for word in [
        controlword::ENABLE_OPERATION | CONTROL_FAULT_RESET,
        controlword::ENABLE_OPERATION,
    ] {
        bench.command(word, mode::CYCLIC_VELOCITY, target);
        let outputs = bench.run(200);
        assert_eq!(code(&outputs), None);
        assert_eq!(state(&outputs), Some(State::QuickStopActive));
        assert!(bench.velocity.abs() < 0.01, "{}", bench.velocity);
    }
    // After it has been enabled again from "switch on disabled", it runs.
    bench.command(controlword::DISABLE_VOLTAGE, mode::CYCLIC_VELOCITY, target);
    bench.run(20);
    let outputs = bench.enable(mode::CYCLIC_VELOCITY, target);
    assert_eq!(state(&outputs), Some(State::OperationEnabled));

    // If bit 7 stays high, there is no rising edge, so the next fault stays.
    let word = controlword::ENABLE_OPERATION | CONTROL_FAULT_RESET;
    bench.command(word, mode::CYCLIC_VELOCITY, target);
    bench.run(20);
    bench.guard_alive = false;
    bench.run(300);
    bench.guard_alive = true;
    let outputs = bench.run(300);
    assert_eq!(code(&outputs), Some(Fault::GuardLost));
}

#[test]
fn a_blocked_axle_lets_go_within_a_tenth_of_a_second_and_brakes() {
    let mut bench = running(3.0);
    bench.stuck = true;
    let outputs = bench.run(200);
    assert_eq!(code(&outputs), Some(Fault::Blocked));
    assert_eq!(state(&outputs), Some(State::Fault));
    assert_eq!(outputs.bridge, BridgeDemand::Brake);
}

#[test]
fn a_current_that_is_no_number_ends_in_the_brake() {
    for reading in [f32::NAN, f32::INFINITY] {
        let mut bench = running(3.0);
        bench.current_reading = Some(reading);
        let outputs = bench.run(3);
        assert_eq!(code(&outputs), Some(Fault::InvalidReading));
        assert_eq!(outputs.bridge, BridgeDemand::Brake);
    }
}

#[test]
fn a_target_beyond_the_travel_ends_at_its_end() {
    for mode in [mode::CYCLIC_POSITION, mode::PROFILE_POSITION] {
        let mut bench = Bench::axle(&[
            (Setting::PositionMinimum, -200),
            (Setting::PositionMaximum, 250),
            (Setting::FollowingLimit, 5_000),
        ]);
        for (target, end) in [(2.0, 0.25), (-2.0, -0.2)] {
            bench.enable(mode, turning(target));
            let mut furthest = 0.0_f64;
            for _ in 0..1_500 {
                bench.tick();
                furthest = furthest.max(bench.angle * f64::signum(target));
            }
            assert!(
                (bench.angle - end).abs() < 2e-3,
                "mode {mode}: {}",
                bench.angle
            );
            assert!(furthest < f64::abs(end) + 0.02, "mode {mode}: {furthest}");
        }
    }
}

/// Sign of the direction towards a limit switch, and the state of the switches at an angle.
type End = (f64, fn(f64) -> Switches);

/// Limit switches, one for each end. Each closes at the bench's `switch_at`.
const LIMITS: [End; 2] = [
    (1.0, |angle| Switches {
        positive_limit: angle > 0.0,
        ..Switches::default()
    }),
    (-1.0, |angle| Switches {
        negative_limit: angle < 0.0,
        ..Switches::default()
    }),
];

#[test]
fn a_limit_switch_stops_the_way_outward_and_leaves_the_way_back() {
    for (sign, switches) in LIMITS {
        let mut bench = Bench::axle(&[]);
        bench.switch_at = sign * 0.5;
        bench.switches = switches;
        let velocity = sign as i32 * 1_000_000;
        bench.enable(mode::CYCLIC_VELOCITY, velocity);
        let outputs = bench.run(1_500);
        assert_eq!(outputs.active_limit, ActiveLimit::Switch);
        assert!(sign * bench.angle < 0.6, "{}", bench.angle);
        let word = controlword::ENABLE_OPERATION;
        bench.command(word, mode::CYCLIC_VELOCITY, -velocity);
        bench.run(500);
        assert!(sign * bench.angle < 0.3, "{}", bench.angle);
    }
}

#[test]
fn a_speed_beyond_the_limit_is_the_limit() {
    let mut bench = Bench::axle(&[]);
    bench.enable(mode::CYCLIC_VELOCITY, 50_000_000);
    for _ in 0..2_000 {
        bench.tick();
        assert!(bench.velocity < 6.0 * 1.05, "{}", bench.velocity);
    }
    assert!((bench.velocity - 6.0).abs() < 0.05, "{}", bench.velocity);
}

#[test]
fn an_unknown_mode_holds_the_position() {
    let mut bench = running(3.0);
    bench.command(controlword::ENABLE_OPERATION, 77, turning(100.0));
    bench.run(RAMP_MS);
    let held_at = bench.angle;
    bench.load = 5.0;
    bench.run(1_000);
    assert!((bench.angle - held_at).abs() < 0.01);
}

#[test]
fn a_quick_stop_respects_the_limit_switch() {
    for (sign, switches) in LIMITS {
        let mut bench = running(sign * 3.0);
        // The ramp from 3 rad/s at 20 rad/s^2 would travel 0.22 rad.
        let switch = bench.angle + sign * 0.05;
        bench.switch_at = switch;
        bench.switches = switches;
        bench.command(controlword::QUICK_STOP, 0, 0);
        let mut furthest = 0.0_f64;
        for _ in 0..500 {
            bench.tick();
            furthest = furthest.max(sign * (bench.angle - switch));
        }
        // 24 N m on 0.05 kg m^2 take 6 ms and 9 mrad; the loops take as long again.
        assert!(furthest < 0.04, "{furthest} rad beyond the switch");
        let beyond = sign * (bench.angle - switch);
        assert!(beyond < 0.01, "{beyond}");
    }
}

#[test]
fn an_over_current_opens_the_bridge_whatever_is_latched() {
    let mut bench = running(3.0);
    bench.guard_alive = false;
    let outputs = bench.run(300);
    assert_eq!(code(&outputs), Some(Fault::GuardLost));
    bench.current_reading = Some(80.0);
    let outputs = bench.run(5);
    assert_eq!(outputs.bridge, BridgeDemand::Off);
    assert!(outputs.faults.contains(Fault::GuardLost));
    assert!(outputs.faults.contains(Fault::OverCurrent));
    assert_eq!(code(&outputs), Some(Fault::OverCurrent));
}

/// Switches a drive off that holds because set-points were lost.
fn off_with_a_fault() -> Bench {
    let mut bench = running(3.0);
    bench.set_point = None;
    assert_eq!(code(&bench.run(500)), Some(Fault::CommandLost));
    bench.command(controlword::DISABLE_VOLTAGE, mode::CYCLIC_VELOCITY, TARGET);
    // A drive with a guard follows this command once it has come for 20 ms.
    let outputs = bench.run(30);
    assert_eq!(state(&outputs), Some(State::SwitchOnDisabled));
    assert_eq!(outputs.bridge, BridgeDemand::Off);
    bench
}

/// Target of 3 rad/s on the bus, 1e-6 rad/s.
const TARGET: i32 = 3_000_000;

#[test]
fn a_latched_fault_allows_the_guard_a_hold_and_no_operation_until_a_reset() {
    let mut bench = off_with_a_fault();
    bench.load = 1.0;
    bench.run(100);
    assert!(bench.velocity < -1.0, "the load turns it");
    let outputs = bench.enable(mode::CYCLIC_VELOCITY, TARGET);
    assert_eq!(state(&outputs), Some(State::QuickStopActive));
    bench.run(1_000);
    let held_at = bench.angle;
    let outputs = bench.enable(mode::CYCLIC_VELOCITY, TARGET);
    assert_eq!(state(&outputs), Some(State::QuickStopActive));
    assert!((bench.angle - held_at).abs() < 0.01, "{}", bench.angle);
    bench.command(controlword::QUICK_STOP | CONTROL_FAULT_RESET, 0, 0);
    bench.run(12);
    let outputs = bench.enable(mode::CYCLIC_VELOCITY, TARGET);
    assert_eq!(state(&outputs), Some(State::OperationEnabled));
}

#[test]
fn a_latched_fault_keeps_the_drive_of_a_client_down_until_a_reset() {
    let mut bench = off_with_a_fault();
    bench.guard_alive = false;
    bench.run(500);
    bench.client = true;
    let outputs = bench.enable(mode::CYCLIC_VELOCITY, TARGET);
    assert_eq!(state(&outputs), Some(State::SwitchOnDisabled));
    bench.command(CONTROL_FAULT_RESET, mode::CYCLIC_VELOCITY, TARGET);
    bench.run(8);
    bench.client = true;
    let outputs = bench.enable(mode::CYCLIC_VELOCITY, TARGET);
    assert_eq!(state(&outputs), Some(State::OperationEnabled));
}

#[test]
fn a_reset_with_quick_stop_clears_the_fault_and_goes_on_holding() {
    let mut bench = running(3.0);
    bench.guard_alive = false;
    bench.run(500);
    // The fault stays while its cause persists.
    for word in [
        controlword::QUICK_STOP | CONTROL_FAULT_RESET,
        controlword::QUICK_STOP,
    ] {
        bench.command(word, 0, 0);
        assert_eq!(code(&bench.run(20)), Some(Fault::GuardLost));
    }
    bench.guard_alive = true;
    bench.load = 5.0;
    bench.run(1_000);
    let held_at = bench.angle;
    bench.command(controlword::QUICK_STOP | CONTROL_FAULT_RESET, 0, 0);
    let outputs = bench.run(200);
    assert_eq!(code(&outputs), None);
    assert_eq!(state(&outputs), Some(State::QuickStopActive));
    assert!(matches!(outputs.bridge, BridgeDemand::Current(_)));
    // When it is enabled again, it takes over the load without letting go.
    bench.command(controlword::ENABLE_OPERATION, mode::CYCLIC_VELOCITY, 0);
    let outputs = bench.run(200);
    assert_eq!(state(&outputs), Some(State::OperationEnabled));
    let moved = (bench.angle - held_at).abs();
    assert!(moved < 0.005, "gave way by {moved} rad");
}
