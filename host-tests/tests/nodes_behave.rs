//! What docs/nodes.md promises of axle and screw, each promise by itself on a bench: the very ticks that are flashed, with
//! a rotor.

mod bench;

use bench::{Bench, Node, settings, state};
use std::f64::consts::TAU;
use tautrack::bus::pdo::DriveMotion;
use tautrack::faults::Fault;
use tautrack::node::Switches;
use tautrack::node::axle::{ActiveLimit, Bridge, Outputs, mode};
use tautrack::node::cia402::{CONTROL_FAULT_RESET, CONTROL_START, State, controlword, status};
use tautrack::node::screw::Screw;
use tautrack::settings::Setting;

/// Bus units of an axle's position with 16 fraction bits.
fn turning(radians: f64) -> i32 {
    (radians / TAU * 65_536.0).round() as i32
}

fn code(outputs: &Outputs) -> Option<Fault> {
    Fault::from_code(outputs.status.error_code)
}

/// The axle ramps to standstill within `within_ms`, and holds there against 5 N m for two seconds.
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
    assert!(matches!(outputs.bridge, Bridge::Current(_)));
    let moved = (bench.angle - held_at).abs();
    assert!(moved < 0.01, "gave way by {moved} rad");
}

/// 3 rad/s down at 20 rad/s^2 takes 150 ms; the loops settle to 0.03 rad/s in another 150.
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
fn an_axle_that_never_heard_a_guard_obeys_whoever_sends_set_points() {
    let mut bench = Bench::axle(&[]);
    bench.guard_alive = false;
    bench.enable(mode::CYCLIC_VELOCITY, 1_000_000);
    let outputs = bench.run(1_000);
    assert_eq!(code(&outputs), None);
    assert!((bench.velocity - 1.0).abs() < 0.02, "{}", bench.velocity);
}

#[test]
fn a_stop_is_a_ramp_and_no_jerk() {
    let mut bench = running(3.0);
    bench.command(controlword::QUICK_STOP, 0, 0);
    let mut last = bench.velocity;
    for _ in 0..RAMP_MS {
        bench.tick();
        // The limit is 20 rad/s^2; the loop that follows it may need a little more for a moment.
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
    // The master comes back and goes on as before: nothing moves.
    bench.command(controlword::ENABLE_OPERATION, mode::CYCLIC_VELOCITY, target);
    let outputs = bench.run(500);
    assert_eq!(code(&outputs), Some(Fault::CommandLost));
    assert_eq!(state(&outputs), Some(State::QuickStopActive));
    // A reset in the middle of it clears the fault, and nothing moves still.
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
    // Enabled anew on purpose, it runs.
    bench.command(controlword::DISABLE_VOLTAGE, mode::CYCLIC_VELOCITY, target);
    bench.run(20);
    let outputs = bench.enable(mode::CYCLIC_VELOCITY, target);
    assert_eq!(state(&outputs), Some(State::OperationEnabled));

    // With bit 7 high all along there is no edge, so the next fault stays.
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
    assert_eq!(outputs.bridge, Bridge::Brake);
}

#[test]
fn a_current_that_is_no_number_ends_in_the_brake() {
    for reading in [f32::NAN, f32::INFINITY] {
        let mut bench = running(3.0);
        bench.current_reading = Some(reading);
        let outputs = bench.run(3);
        assert_eq!(code(&outputs), Some(Fault::InvalidReading));
        assert_eq!(outputs.bridge, Bridge::Brake);
    }
}

/// An axle whose reference switch closes beyond 0.5 rad, a place that it shall call 0.35 rad.
fn unreferenced() -> Bench {
    let mut bench = Bench::axle(&[
        (Setting::ReferenceDirection, 1),
        (Setting::ReferencePosition, 350_000),
    ]);
    bench.switches = |angle| Switches {
        reference: angle >= 0.5,
        ..Switches::default()
    };
    bench
}

#[test]
fn a_reference_run_ends_where_the_switch_opens_and_calls_it_the_reference_position() {
    let mut bench = unreferenced();
    bench.enable(mode::HOMING, 0);
    let word = controlword::ENABLE_OPERATION | CONTROL_START;
    bench.command(word, mode::HOMING, 0);
    let mut furthest = 0.0_f64;
    for _ in 0..6_000 {
        bench.tick();
        furthest = furthest.max(bench.angle);
    }
    let outputs = bench.tick();
    assert_ne!(outputs.status.statusword & status::REFERENCED, 0);
    assert!(furthest > 0.5, "it saw the switch close");
    assert!(bench.angle < 0.5 && bench.angle > 0.48, "{}", bench.angle);
    let said = f64::from(outputs.motion.position) / 65_536.0 * TAU;
    let truth = bench.angle - 0.5 + 0.35;
    assert!((said - truth).abs() < 1e-3, "{said} {truth}");
}

#[test]
fn a_reference_run_starts_only_by_the_edge_of_its_bit() {
    let mut bench = unreferenced();
    bench.enable(mode::HOMING, 0);
    bench.run(1_000);
    assert!(bench.angle.abs() < 1e-3, "{}", bench.angle);
}

#[test]
fn a_reference_switch_that_never_closes_is_a_fault_after_20_s() {
    let mut bench = unreferenced();
    bench.switches = |_| Switches::default();
    bench.enable(mode::HOMING, 0);
    let word = controlword::ENABLE_OPERATION | CONTROL_START;
    bench.command(word, mode::HOMING, 0);
    assert_eq!(code(&bench.run(19_900)), None);
    assert_eq!(code(&bench.run(200)), Some(Fault::ReferenceFailed));
}

#[test]
fn an_axle_that_is_not_referenced_goes_to_no_position() {
    for mode in [mode::CYCLIC_POSITION, mode::PROFILE_POSITION] {
        let mut bench = unreferenced();
        let outputs = bench.enable(mode, turning(1.0));
        assert_eq!(outputs.active_limit, ActiveLimit::NotReferenced);
        bench.run(500);
        assert!(bench.angle.abs() < 1e-3, "{}", bench.angle);
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

#[test]
fn a_limit_switch_stops_the_way_outward_and_leaves_the_way_back() {
    let mut bench = Bench::axle(&[]);
    bench.switches = |angle| Switches {
        positive_limit: angle > 0.5,
        ..Switches::default()
    };
    bench.enable(mode::CYCLIC_VELOCITY, 1_000_000);
    let outputs = bench.run(1_500);
    assert_eq!(outputs.active_limit, ActiveLimit::Switch);
    assert!(bench.angle < 0.6, "{}", bench.angle);
    bench.command(
        controlword::ENABLE_OPERATION,
        mode::CYCLIC_VELOCITY,
        -1_000_000,
    );
    bench.run(500);
    assert!(bench.angle < 0.3, "{}", bench.angle);
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

/// B2P2's lengths, m.
const L1: f64 = 0.32;
const L2: f64 = 0.23;
const K: f64 = 1.232;

/// Extension at which `L + (L2 + L3) = K`, found by bisection of the triangle of the three axles, not by the firmware's
/// formula.
fn taut(theta: f64) -> f64 {
    let excess = |l3: f64| {
        let reach = L2 + l3;
        let l = (L1 * L1 + reach * reach + 2.0 * L1 * reach * theta.cos()).sqrt();
        l + reach - K
    };
    let (mut low, mut high) = (0.0, K);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if excess(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Metres that the screw says it is extended.
fn extension(outputs: &Outputs) -> f64 {
    f64::from(outputs.motion.position) / 16_777_216.0
}

fn joint(theta: f64, rate: f64) -> DriveMotion {
    DriveMotion {
        position: (theta / TAU * 4_294_967_296.0) as i64 as i32,
        velocity: (rate * 1e6) as i32,
    }
}

/// B2P2's screw, referenced by its switch and taut at joint angle 0.
fn engaged() -> Bench {
    let settings = settings(&[
        (Setting::GearRatio, 4_000),
        (Setting::VelocityLimit, 140_000),
        (Setting::AccelerationLimit, 2_000_000),
        (Setting::VelocityGain, 300),
        (Setting::VelocityIntegralTime, 30_000),
        (Setting::PositionGain, 60_000),
        (Setting::FollowingLimit, 6_000),
        (Setting::ReferenceDirection, -1),
        (Setting::ReferenceSpeed, 25_000),
    ]);
    let screw = Screw::new(&settings).expect("B2P2's geometry");
    let mut bench = Bench::new(Node::Screw(screw), &settings, 1.6e-4);
    bench.joint = Some(joint(0.0, 0.0));
    bench.switches = |angle| Switches {
        reference: angle < -5.0,
        ..Switches::default()
    };
    bench.enable(mode::HOMING, 0);
    let word = controlword::ENABLE_OPERATION | CONTROL_START;
    bench.command(word, mode::HOMING, 0);
    let outputs = bench.run(3_000);
    assert_ne!(outputs.status.statusword & status::REFERENCED, 0);
    bench.enable(mode::TAUT, 0);
    let outputs = bench.run(3_000);
    let error = extension(&outputs) - taut(0.0);
    assert!(error.abs() < 1e-4, "{error} m from taut");
    bench
}

#[test]
fn screw_keeps_the_belt_taut_while_the_joint_turns() {
    let mut bench = engaged();
    let (mut theta, mut worst) = (0.0_f64, 0.0_f64);
    for tick in 0..3_000 {
        // Up to 0.5 rad/s, from 0 to 1 rad and on its way back.
        let rate = 0.5 * (f64::from(tick) / 3_000.0 * 1.5 * TAU / 2.0).sin();
        theta += rate * 1e-3;
        bench.joint = Some(joint(theta, rate));
        let outputs = bench.tick();
        let error = extension(&outputs) - taut(theta);
        worst = worst.max(error.abs());
    }
    assert!(worst < 3e-4, "{worst} m");
    println!("worst distance from taut: {worst} m");
}

#[test]
fn screw_holds_when_the_joint_falls_silent() {
    let mut bench = engaged();
    let mut theta = 0.0;
    for _ in 0..1_000 {
        theta += 0.5e-3;
        bench.joint = Some(joint(theta, 0.5));
        bench.tick();
    }
    bench.joint = None;
    let before = bench.run(20);
    assert_eq!(code(&before), None, "joint_timeout is 24 ms");
    let outputs = bench.run(80);
    assert_eq!(code(&outputs), Some(Fault::JointLost));
    assert_eq!(state(&outputs), Some(State::QuickStopActive));
    let held_at = extension(&outputs);
    bench.load = 0.2;
    let outputs = bench.run(2_000);
    assert!(matches!(outputs.bridge, Bridge::Current(_)));
    let moved = (extension(&outputs) - held_at).abs();
    assert!(moved < 1e-4, "gave way by {moved} m");
}
