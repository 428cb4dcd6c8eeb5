//! Tests of homing: both approaches, the debounced switch, and the limits during homing.

use super::bench::{Bench, state};
use super::{code, turning};
use std::f64::consts::TAU;
use tautrack::bus::cia402::{CONTROL_START, State, controlword, mode, status};
use tautrack::faults::Fault;
use tautrack::node::axle::{ActiveLimit, BridgeDemand};
use tautrack::sensors::Switches;
use tautrack::settings::Setting;

/// Creates an axle whose home switch closes beyond 0.5 rad; the home position is 0.35 rad.
fn unhomed() -> Bench {
    let mut bench = Bench::axle(&[
        (Setting::HomingDirection, 1),
        (Setting::HomePosition, 350_000),
    ]);
    bench.switches = |angle| Switches {
        home: angle >= 0.5,
        ..Switches::default()
    };
    bench
}

/// Starts homing.
fn start(bench: &mut Bench) {
    bench.enable(mode::HOMING, 0);
    let word = controlword::ENABLE_OPERATION | CONTROL_START;
    bench.command(word, mode::HOMING, 0);
}

/// Error of the axle's position after homing, rad. The switch of [`unhomed`] is at 0.5 rad, which
/// is position 0.35 rad.
fn error(bench: &mut Bench) -> f64 {
    let outputs = bench.tick();
    assert_ne!(outputs.status.statusword & status::HOMED, 0);
    let believed = f64::from(outputs.motion.position) / 65_536.0 * TAU;
    believed - (bench.angle - 0.5 + 0.35)
}

#[test]
fn homing_ends_where_the_switch_closes_and_calls_it_the_home_position() {
    let mut bench = unhomed();
    start(&mut bench);
    bench.run(6_000);
    let error = error(&mut bench);
    // The tolerance is the travel of one tick of the second approach, at 0.06 rad/s, plus one unit
    // of the position on the bus.
    assert!(error.abs() < 3e-4, "{error}");
    let outputs = bench.tick();
    assert!((bench.angle - 0.5).abs() < 0.01, "{}", bench.angle);
    assert!(outputs.homing_difference.abs() < (1e-3 / TAU * 4_294_967_296.0) as i32);
}

/// The screw's switch is approached at 25 rad/s and read two ticks late, at 25 phases of the ticks.
#[test]
fn a_switch_that_reacts_late_is_found_at_any_distance() {
    for distance in 0..25 {
        let mut bench = Bench::axle(&[
            (Setting::HomingDirection, 1),
            (Setting::HomingSpeed, 25_000),
            (Setting::VelocityLimit, 50_000),
            (Setting::AccelerationLimit, 500_000),
        ]);
        bench.inertia = 1e-3;
        bench.switches = |angle| Switches {
            home: angle >= 0.0,
            ..Switches::default()
        };
        let place = 2.0 + 1e-3 * f64::from(distance);
        let mut before = [0.0; 2];
        start(&mut bench);
        for _ in 0..3_000 {
            bench.switch_at = place + bench.angle - before[0];
            before = [before[1], bench.angle];
            bench.tick();
        }
        let outputs = bench.tick();
        let fault = code(&outputs);
        assert_ne!(
            outputs.status.statusword & status::HOMED,
            0,
            "{distance} mrad: {fault:?} after {}",
            outputs.homing_difference
        );
    }
}

#[test]
fn homing_that_begins_on_the_switch_finds_the_same_place() {
    let mut bench = unhomed();
    bench.angle = 0.6;
    start(&mut bench);
    bench.run(6_000);
    let error = error(&mut bench);
    assert!(error.abs() < 3e-4, "{error}");
}

#[test]
fn a_glitch_of_the_switch_is_no_home_position() {
    let mut bench = unhomed();
    bench.switches = |angle| Switches {
        // The switch closes for 1 ms at 0.10 rad, which is 0.3 mrad at 0.3 rad/s.
        home: angle >= 0.5 || (0.1..0.1003).contains(&angle),
        ..Switches::default()
    };
    start(&mut bench);
    bench.run(6_000);
    let error = error(&mut bench);
    assert!(error.abs() < 3e-4, "{error}");
}

#[test]
fn approaches_that_disagree_are_a_fault_with_their_distance() {
    let mut bench = unhomed();
    start(&mut bench);
    bench.run(400);
    let glitch = bench.angle;
    // The switch is closed long enough to be accepted.
    bench.switches = |_| Switches {
        home: true,
        ..Switches::default()
    };
    bench.run(10);
    bench.switches = unhomed().switches;
    let outputs = bench.run(9_000);
    assert_eq!(code(&outputs), Some(Fault::HomingMismatch));
    assert_eq!(outputs.status.statusword & status::HOMED, 0);
    assert_eq!(state(&outputs), Some(State::QuickStopActive));
    let difference = f64::from(outputs.homing_difference) / 4_294_967_296.0 * TAU;
    let truth = 0.5 - glitch;
    assert!((difference - truth).abs() < 2e-3, "{difference} {truth}");
}

#[test]
fn homing_keeps_its_own_current_and_speed() {
    let mut bench = Bench::axle(&[
        (Setting::HomingDirection, 1),
        (Setting::HomingCurrent, 2_000),
    ]);
    start(&mut bench);
    bench.load = 0.5;
    for tick in 0..1_000 {
        let outputs = bench.tick();
        // The load pulls in the direction of motion for half of the time. The loops then brake with
        // no more current either.
        bench.load = if tick % 200 < 100 { 0.5 } else { -0.5 };
        match outputs.bridge {
            BridgeDemand::Current(current) => assert!(current.abs() <= 2.0, "{current} A"),
            bridge => panic!("{bridge:?}"),
        }
        assert!(
            bench.velocity.abs() < 0.45,
            "{} rad/s at {tick}",
            bench.velocity
        );
    }
}

#[test]
fn homing_starts_only_by_the_edge_of_its_bit() {
    let mut bench = unhomed();
    bench.enable(mode::HOMING, 0);
    bench.run(1_000);
    assert!(bench.angle.abs() < 1e-3, "{}", bench.angle);
}

#[test]
fn a_home_switch_that_never_closes_is_a_fault_after_20_s() {
    let mut bench = unhomed();
    bench.switches = |_| Switches::default();
    bench.enable(mode::HOMING, 0);
    let word = controlword::ENABLE_OPERATION | CONTROL_START;
    bench.command(word, mode::HOMING, 0);
    assert_eq!(code(&bench.run(19_900)), None);
    assert_eq!(code(&bench.run(200)), Some(Fault::HomingFailed));
}

#[test]
fn an_axle_that_is_not_homed_goes_to_no_position() {
    for mode in [mode::CYCLIC_POSITION, mode::PROFILE_POSITION] {
        let mut bench = unhomed();
        let outputs = bench.enable(mode, turning(1.0));
        assert_eq!(outputs.active_limit, ActiveLimit::NotHomed);
        bench.run(500);
        assert!(bench.angle.abs() < 1e-3, "{}", bench.angle);
    }
}
