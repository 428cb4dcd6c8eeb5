//! Tests of the effect of a torque offset (object 60B2h) on axle and screw.

use crate::bench::{Bench, Node, settings, state};
use tautrack::bus::cia402::{State, controlword, mode};
use tautrack::bus::pdo::DriveMotion;
use tautrack::node::axle::{BridgeDemand, Outputs};
use tautrack::node::screw::Screw;
use tautrack::settings::Setting;

fn current(outputs: &Outputs) -> f32 {
    match outputs.bridge {
        BridgeDemand::Current(current) | BridgeDemand::Braking { current, .. } => current,
        _ => f32::NAN,
    }
}

/// Creates an axle whose rotor stands at its set-point, so that all current comes from the torque
/// offset (2.4 N m/A).
fn standing() -> Bench {
    let mut bench = Bench::axle(&[]);
    bench.stuck = true;
    bench.enable(mode::CYCLIC_POSITION, 0);
    bench
}

#[test]
fn an_axle_adds_the_current_that_its_torque_offset_means() {
    let mut bench = standing();
    for torque in [240_i16, -120, 0] {
        bench.torque_offset = Some(torque);
        let outputs = bench.run(40);
        let wanted = f32::from(torque) / 240.0;
        assert!((current(&outputs) - wanted).abs() < 1e-4, "{outputs:?}");
    }
}

#[test]
fn a_screws_torque_offset_is_a_force() {
    // Without a velocity gain, all current comes from the torque offset, whatever the set-point is.
    let settings = settings(&[
        (Setting::GearRatio, 4_000),
        (Setting::VelocityGain, 0),
        (Setting::FollowingLimit, 100_000),
    ]);
    let screw = Screw::new(&settings).unwrap();
    let mut bench = Bench::new(Node::Screw(screw), &settings, 1.6e-4);
    bench.stuck = true;
    bench.joint = Some(DriveMotion::default());
    bench.enable(mode::TAUT, 0);
    bench.torque_offset = Some(1_000);
    let outputs = bench.run(40);
    let added = current(&outputs);
    // 1 kN on a lead of 5 mm is 0.796 N m, at 0.16 N m/A.
    assert!((added - 4.974).abs() < 1e-3, "{outputs:?}");
}

#[test]
fn a_torque_offset_never_passes_the_current_limit() {
    let mut bench = standing();
    for torque in [i16::MAX, i16::MIN] {
        bench.torque_offset = Some(torque);
        // The time is too short for the axle to count as blocked.
        let outputs = bench.run(20);
        assert!(current(&outputs).abs() <= 10.0, "{outputs:?}");
        assert!(current(&outputs).abs() > 9.99, "{outputs:?}");
    }
}

#[test]
fn a_torque_offset_counts_in_operation_alone_and_ends_with_it() {
    let mut bench = Bench::axle(&[]);
    bench.stuck = true;
    bench.torque_offset = Some(240);
    bench.run(100);
    bench.torque_offset = None;
    let outputs = bench.enable(mode::CYCLIC_POSITION, 0);
    assert_eq!(current(&outputs), 0.0);
    bench.torque_offset = Some(240);
    assert!(current(&bench.run(40)) > 0.9);
    bench.command(controlword::QUICK_STOP, 0, 0);
    let outputs = bench.run(40);
    assert_eq!(state(&outputs), Some(State::QuickStopActive));
    assert!(current(&outputs).abs() < 0.1, "{outputs:?}");
}

#[test]
fn a_torque_offset_ends_when_the_guard_falls_silent() {
    let mut bench = standing();
    bench.torque_offset = Some(240);
    assert!(current(&bench.run(200)) > 0.9);
    bench.guard_alive = false;
    let outputs = bench.run(200);
    assert_ne!(outputs.status.error_code, 0);
    assert!(current(&outputs).abs() < 0.1, "{outputs:?}");
}

#[test]
fn a_torque_offset_ages_though_set_points_go_on() {
    let mut bench = standing();
    bench.torque_offset = Some(240);
    bench.run(40);
    bench.torque_offset = None;
    assert!(current(&bench.run(40)) > 0.9, "command_timeout is 60 ms");
    let outputs = bench.run(60);
    assert!(current(&outputs).abs() < 1e-4, "{outputs:?}");
    assert_eq!(outputs.status.error_code, 0);
}

#[test]
fn a_load_with_feed_forward_moves_the_axle_less() {
    let moved = |torque_offset| {
        let mut bench = Bench::axle(&[]);
        bench.enable(mode::CYCLIC_POSITION, 0);
        // Load and offset start in the tick before which the first offset is received.
        while !(bench.now_us / 1_000 + 1).is_multiple_of(16) {
            bench.tick();
        }
        (bench.load, bench.torque_offset) = (5.0, torque_offset);
        (0..200)
            .map(|_| {
                bench.tick();
                bench.angle.abs()
            })
            .fold(0.0, f64::max)
    };
    let (without, with) = (moved(None), moved(Some(500)));
    assert!(with < 0.25 * without, "{with} rad, {without} without");
}
