//! Tests of the brake's sequence, on an axle with the motor model and a load that pulls. The brake
//! of the bench needs its times to release and to engage.

use super::drive_bench::{Bench, MOTOR};
use tautrack::bus::cia402::{State, controlword, mode};
use tautrack::motor::model::MotorModel;
use tautrack::node::axle::BridgeDemand;
use tautrack::settings::Setting;

const RELEASE_MS: usize = 40;
const ENGAGE_MS: usize = 30;
const BRAKED: MotorModel = MotorModel {
    brake_torque: 30.0,
    ..MOTOR
};

/// An axle at rest under a load of 10 N m, with a brake.
fn braked(settings: bool) -> Bench {
    let times = [
        (Setting::BrakeReleaseTime, RELEASE_MS as i32),
        (Setting::BrakeEngageTime, ENGAGE_MS as i32),
    ];
    let mut bench = Bench::new(if settings { &times } else { &[] }, BRAKED);
    bench.brake_ms = Some([RELEASE_MS, ENGAGE_MS]);
    bench.load = 10.0;
    bench
}

/// Largest distance from the present angle within this time, rad.
fn travel(bench: &mut Bench, milliseconds: usize) -> f64 {
    let start = bench.angle();
    (0..milliseconds).fold(0.0, |largest: f64, _| {
        bench.tick();
        largest.max((bench.angle() - start).abs())
    })
}

#[test]
fn a_load_does_not_drop_when_a_drive_is_armed_and_disarmed() {
    let mut bench = braked(true);
    bench.torque_offset = Some(1_000);
    bench.run(100);
    bench.enable(mode::CYCLIC_POSITION, 0);
    // The current loop carries the load before the brake lets go.
    let arming = travel(&mut bench, 500);
    assert!(bench.outputs.brake_released);
    bench.word = controlword::DISABLE_VOLTAGE;
    let disarming = travel(&mut bench, 500);
    assert_eq!(bench.state(), State::SwitchOnDisabled);
    assert_eq!(bench.outputs.bridge, BridgeDemand::Off);
    assert!(
        arming < 3e-3 && disarming < 3e-3,
        "{arming} {disarming} rad"
    );

    // Without the times the load drops while the brake engages.
    let mut bench = braked(false);
    bench.torque_offset = Some(1_000);
    bench.enable(mode::CYCLIC_POSITION, 0);
    bench.run(500);
    bench.word = controlword::DISABLE_VOLTAGE;
    let dropped = travel(&mut bench, 500);
    assert!(dropped > 0.05, "{dropped} rad");
}

#[test]
fn without_feed_forward_the_position_loop_catches_the_load() {
    let mut bench = braked(true);
    bench.enable(mode::CYCLIC_POSITION, 0);
    let arming = travel(&mut bench, 1_000);
    assert!(arming < 0.06, "{arming} rad");
    assert!(bench.angle().abs() < 2e-3, "{} rad", bench.angle());
}

#[test]
fn no_drive_moves_against_its_brake() {
    let mut bench = braked(true);
    bench.load = 0.0;
    bench.enable(mode::CYCLIC_VELOCITY, 3_000_000);
    for _ in 0..RELEASE_MS {
        let BridgeDemand::Current(current) = bench.outputs.bridge else {
            panic!("off");
        };
        assert!(current.abs() < 0.5, "{current} A against the brake");
        bench.tick();
    }
    bench.run(400);
    assert!(bench.velocity() > 2.5, "{} rad/s", bench.velocity());
}

#[test]
fn a_fault_engages_the_brake_at_once() {
    let mut bench = braked(true);
    bench.enable(mode::CYCLIC_VELOCITY, 3_000_000);
    bench.run(500);
    assert!(bench.outputs.brake_released);
    bench.motor.freeze_sensor(true);
    while matches!(bench.outputs.bridge, BridgeDemand::Current(_)) {
        assert!(bench.outputs.brake_released);
        bench.tick();
    }
    assert!(!bench.outputs.brake_released);
}

#[test]
fn disable_voltage_stops_a_turning_axle_at_once() {
    let mut bench = braked(true);
    bench.enable(mode::CYCLIC_VELOCITY, 3_000_000);
    bench.run(500);
    bench.send(controlword::DISABLE_VOLTAGE, 4);
    assert_eq!(bench.outputs.bridge, BridgeDemand::Off);
    assert!(!bench.outputs.brake_released);
}

#[test]
fn a_new_enable_operation_releases_a_brake_that_engages() {
    let mut bench = braked(true);
    bench.set(|p| p.shutdown = 1);
    bench.enable(mode::CYCLIC_VELOCITY, 0);
    bench.run(300);
    bench.send(controlword::SHUTDOWN, 16);
    assert!(!bench.outputs.brake_released);
    assert_eq!(bench.state(), State::OperationEnabled);
    bench.send(controlword::ENABLE_OPERATION, 300);
    assert!(bench.outputs.brake_released);
    assert_eq!(bench.state(), State::OperationEnabled);
}

/// The load grows while the brake engages, and the shaft gives way for some milliseconds.
#[test]
fn a_brake_that_engages_goes_on_engaging_when_the_shaft_moves() {
    let engaging = |load: f32| {
        let mut bench = braked(true);
        bench.set(|p| p.shutdown = 1);
        bench.enable(mode::CYCLIC_VELOCITY, 0);
        bench.run(500);
        bench.word = controlword::SHUTDOWN;
        while bench.outputs.brake_released {
            bench.tick();
        }
        bench.load = load;
        bench.run(3);
        let moves = bench.velocity().abs() > 0.06;
        (moves, bench.until_off())
    };
    let (still, moved) = (engaging(10.0), engaging(23.0));
    assert_eq!((still.0, moved.0), (false, true));
    assert!(still.1.is_some());
    assert_eq!(still.1, moved.1);
}
