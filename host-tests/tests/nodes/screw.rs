//! Tests of the screw: it keeps the belt taut while the joint turns, holds if the joint's motion is
//! not received, and never moves below the released length.

use super::bench::{Bench, Node, settings, state};
use super::code;
use std::f64::consts::TAU;
use tautrack::bus::cia402::{CONTROL_HALT, CONTROL_START, State, controlword, mode, status};
use tautrack::bus::pdo::DriveMotion;
use tautrack::faults::Fault;
use tautrack::node::axle::{BridgeDemand, Outputs};
use tautrack::node::screw::Screw;
use tautrack::screw::Geometry;
use tautrack::sensors::Switches;
use tautrack::settings::Setting;

/// Lengths of B2P2, m.
const L1: f64 = 0.32;
const L2: f64 = 0.23;
const K: f64 = 1.232;

/// Extension at which `L + (L2 + L3) = K`, m. It is computed by bisection on the triangle of the
/// three axles, independently of the firmware's formula.
fn taut(theta: f64) -> f64 {
    taut_with(theta, 0.0)
}

/// The same for a belt with this slack.
fn taut_with(theta: f64, slack: f64) -> f64 {
    let excess = |l3: f64| {
        let reach = L2 + l3;
        let l = (L1 * L1 + reach * reach + 2.0 * L1 * reach * theta.cos()).sqrt();
        l + reach - (K - slack)
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

/// Extension that the screw reports, m.
fn extension(outputs: &Outputs) -> f64 {
    f64::from(outputs.motion.position) / 16_777_216.0
}

fn joint(theta: f64, rate: f64) -> DriveMotion {
    DriveMotion {
        position: (theta / TAU * 4_294_967_296.0) as i64 as i32,
        velocity: (rate * 1e6) as i32,
    }
}

/// Creates B2P2's screw, homed, and taut at joint angle 0.
fn engaged() -> Bench {
    let settings = settings(&[
        (Setting::GearRatio, 4_000),
        (Setting::VelocityLimit, 140_000),
        (Setting::AccelerationLimit, 2_000_000),
        (Setting::VelocityGain, 300),
        (Setting::VelocityIntegralTime, 30_000),
        (Setting::PositionGain, 60_000),
        (Setting::FollowingLimit, 6_000),
        (Setting::HomingDirection, -1),
        (Setting::HomingSpeed, 25_000),
    ]);
    let screw = Screw::new(&settings).expect("B2P2's geometry");
    let mut bench = Bench::new(Node::Screw(screw), &settings, 1.6e-4);
    bench.joint = Some(joint(0.0, 0.0));
    bench.switches = |angle| Switches {
        home: angle < -5.0,
        ..Switches::default()
    };
    bench.enable(mode::HOMING, 0);
    let word = controlword::ENABLE_OPERATION | CONTROL_START;
    bench.command(word, mode::HOMING, 0);
    let outputs = bench.run(3_000);
    assert_ne!(outputs.status.statusword & status::HOMED, 0);
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
        // Up to 0.5 rad/s, from 0 to 1 rad and partly back.
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
    assert!(matches!(outputs.bridge, BridgeDemand::Current(_)));
    let moved = (extension(&outputs) - held_at).abs();
    assert!(moved < 1e-4, "gave way by {moved} m");
}

/// Extension at which the belt is slack at every angle of the joint, m.
fn released() -> f64 {
    let geometry = Geometry::from_micrometres(320_000, 230_000, 1_232_000).expect("B2P2's");
    f64::from(geometry.released_length().to_bits()) / 268_435_456.0
}

/// Commands a slack in mode `RELEASED`; 0 in mode `TAUT`.
fn release(bench: &mut Bench, slack: f64) {
    let mode = if slack > 0.0 {
        mode::RELEASED
    } else {
        mode::TAUT
    };
    let target = (slack * 16_777_216.0) as i32;
    bench.command(controlword::ENABLE_OPERATION, mode, target);
}

/// Maximum distance by which the screw may move below the released length, m. One unit of its
/// position is 0.06 um.
const DIP: f64 = 20e-6;

#[test]
fn a_slack_screw_never_dips_below_the_released_length() {
    let released = released();
    for slack in [5e-3, 30e-3, 0.2] {
        let mut bench = engaged();
        release(&mut bench, slack);
        let (mut theta, mut lowest, mut highest) = (0.0_f64, f64::INFINITY, 0.0_f64);
        for tick in 0..12_000 {
            // Back and forth between 1.2 and -0.4 rad at 0.8 rad/s, with sudden stops.
            let rate = match tick % 4_500 {
                1_500..2_000 => 0.0,
                2_000..4_000 => -0.8,
                _ => 0.8,
            };
            theta += rate * 1e-3;
            bench.joint = Some(joint(theta, rate));
            let outputs = bench.tick();
            lowest = lowest.min(extension(&outputs) - released);
            highest = highest.max(extension(&outputs) - released);
        }
        println!("slack {slack} m: {lowest:.6} to {highest:.6} m above the released length");
        assert!(lowest > -DIP, "slack {slack} m: {lowest} m");
    }
}

#[test]
fn a_slack_that_is_commanded_is_approached_with_the_engage_speed() {
    let mut bench = engaged();
    raise(&mut bench);
    let before = extension(&bench.tick());
    release(&mut bench, 0.01);
    let mut last = before;
    for _ in 0..1_500 {
        let now = extension(&bench.tick());
        // The limit is 20 mm/s, plus half of it for the loops.
        assert!((now - last).abs() < 30e-6, "{} m/s", (now - last) * 1e3);
        last = now;
    }
    assert!(before - last > 3e-3, "it drew back by {} m", before - last);
}

/// Turns the joint to 0.8 rad at 0.5 rad/s, where the belt can be released by 44 mm.
fn raise(bench: &mut Bench) {
    for tick in 0..1_600 {
        bench.joint = Some(joint(f64::from(tick) * 0.5e-3, 0.5));
        bench.tick();
    }
    bench.joint = Some(joint(0.8, 0.0));
    bench.run(500);
}

/// The screw is released, and something holds the belt: tightening it takes more than the current
/// limit gives.
#[test]
fn a_belt_that_cannot_be_pulled_back_is_reported_and_the_screw_gets_no_current() {
    let mut bench = engaged();
    raise(&mut bench);
    release(&mut bench, 0.03);
    bench.run(2_000);
    release(&mut bench, 0.0);
    bench.stuck = true;
    let reported = (0..2_000).find_map(|_| code(&bench.tick()));
    assert_eq!(reported, Some(Fault::Blocked));
    for _ in 0..1_000 {
        let outputs = bench.tick();
        assert_eq!(state(&outputs), Some(State::Fault));
        assert_eq!(outputs.bridge, BridgeDemand::Brake);
    }
}

/// The joint turns faster than the velocity limit lets the screw follow: 111 mm/s.
#[test]
fn a_joint_that_turns_too_fast_for_a_released_screw_is_reported() {
    let mut bench = engaged();
    raise(&mut bench);
    release(&mut bench, 0.02);
    bench.run(1_500);
    let mut theta = 0.8;
    let reported = (0..1_000).find_map(|_| {
        theta += 1.5e-3;
        bench.joint = Some(joint(theta, 1.5));
        code(&bench.tick())
    });
    assert!(
        matches!(reported, Some(Fault::FollowingError | Fault::DuplicateId)),
        "{reported:?}"
    );
}

/// In halts, holds and other modes the screw keeps its place. From there the belt gets the
/// commanded slack without a jump, also when the joint has turned meanwhile.
#[test]
fn a_released_screw_goes_on_from_where_it_is_after_a_halt_a_hold_and_another_mode() {
    let halt = controlword::ENABLE_OPERATION | CONTROL_HALT;
    for (word, mode) in [
        (halt, mode::RELEASED),
        (controlword::QUICK_STOP, mode::RELEASED),
        (controlword::ENABLE_OPERATION, mode::CYCLIC_VELOCITY),
        (controlword::ENABLE_OPERATION, mode::TAUT),
    ] {
        let mut bench = engaged();
        raise(&mut bench);
        release(&mut bench, 0.04);
        bench.run(1_000);
        bench.command(word, mode, 0);
        bench.run(40);
        for tick in 0..100 {
            bench.joint = Some(joint(0.8 + f64::from(tick) * 0.5e-3, 0.5));
            bench.tick();
        }
        bench.joint = Some(joint(0.85, 0.0));
        let mut last = extension(&bench.run(200));
        release(&mut bench, 0.04);
        for tick in 0..4_000 {
            let outputs = bench.tick();
            assert_eq!(code(&outputs), None, "{word:#x} {mode} {tick}");
            let now = extension(&outputs);
            // Twice the engage speed, because the slack and the distance to it change at once, plus
            // the loops.
            let step = (now - last).abs();
            assert!(step < 50e-6, "{word:#x} {mode} {tick}: {} m/s", step * 1e3);
            last = now;
        }
        let expected = taut_with(0.85, 0.04);
        assert!((last - expected).abs() < 1e-4, "{mode}: {last} {expected}");
    }
}
