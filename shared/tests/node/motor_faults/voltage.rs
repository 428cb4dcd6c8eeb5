//! Three-phase drives near the speed at which their back-EMF is the voltage of the bridge, and
//! beyond it.

use super::rig::{GEAR, PER_RADIAN, Rig};
use super::wrong_angle::{Drive, between, pick};
use crate::random::Random;
use crate::sweep::cases;
use tautrack::bus::cia402::mode;
use tautrack::faults::Fault;
use tautrack::node::axle::{ActiveLimit, Outputs};
use tautrack::settings::Setting;

/// Speed of the output shaft at which the back-EMF is the bridge's largest voltage, rad/s.
const BASE: f64 = 0.95 * 24.0 / 1.732_050_8 / (0.04 / 1.5 * GEAR);

/// A drive that may turn at 12 rad/s, with this `field_weakening_current`, mA.
fn rig(weakening: i32) -> Rig {
    let changes = [
        (Setting::VelocityLimit, 12_000),
        (Setting::FieldWeakeningCurrent, weakening),
    ];
    Rig::new(true, &changes)
}

fn turn(rig: &mut Rig, velocity: f64) -> Outputs {
    rig.target = (velocity * PER_RADIAN) as i32;
    rig.run(1_500)
}

#[test]
fn a_weaker_field_makes_a_motor_faster() {
    for (weakening, speed) in [(0.0, 0.975), (4.0, 1.18), (8.0, 1.39)] {
        let mut rig = rig((weakening * 1e3) as i32);
        let outputs = turn(&mut rig, 11.9);
        let velocity = f64::from(outputs.velocity) / BASE;
        let direct = f64::from(rig.inputs.unwrap().electrical.direct);
        println!("{weakening} A: {direct:.2} A in d, {velocity:.3} of the speed");
        assert!(velocity > speed, "{weakening} A: {velocity}");
        assert!((direct + weakening).abs() < 0.1, "{weakening} A: {direct}");
        assert_eq!(outputs.active_limit, ActiveLimit::Voltage);
    }
}

#[test]
fn a_motor_that_is_driven_faster_than_its_voltage_allows_follows_its_demand() {
    for load in [-1.0_f32, -4.0, -8.0, -12.0] {
        let mut rig = rig(0);
        turn(&mut rig, 11.0);
        rig.load = load;
        let outputs = rig.run(3_000);
        let inputs = rig.inputs.unwrap();
        let (current, direct) = (inputs.current, inputs.electrical.direct);
        println!(
            "{load} N m: {} rad/s, {current:.2} A and {direct:.2} A in d",
            outputs.velocity
        );
        // The load, less the friction, on 2.4 N m/A, and on the torque that the difference of the
        // inductances makes with the current in d.
        let reluctance = (0.15e-3 - 0.18e-3) * direct / (0.04 / 1.5 / 7.0);
        let expected = (load + 0.5) / (2.4 * (1.0 + reluctance));
        assert!((outputs.velocity - 11.0).abs() < 0.02);
        assert!((current - expected).abs() < 0.1, "{current} {expected}");
        assert!(current.hypot(direct) < 10.1);
        assert!(rig.largest_current < 11.0, "{}", rig.largest_current);
    }
}

#[test]
fn a_supply_whose_voltage_falls_does_not_take_the_control_of_the_current() {
    for step in [0.05_f32, 1.0, 8.0] {
        let mut rig = rig(0);
        turn(&mut rig, 7.8);
        while rig.supply_voltage > 16.0 {
            rig.supply_voltage = (rig.supply_voltage - step).max(16.0);
            rig.run(1);
        }
        rig.run(200);
        println!("{step} V/ms: {:.1} A", rig.largest_current);
        assert!(rig.largest_current < 11.0, "{}", rig.largest_current);
    }
}

#[test]
fn a_shaft_that_coasts_faster_than_its_voltage_allows_is_caught() {
    for velocity in [6.0_f32, 8.0, 9.0, 10.0] {
        let mut rig = rig(0);
        rig.word = Some(6);
        rig.load = -10.0;
        for _ in 0..1_000 {
            if rig.tick().velocity >= velocity {
                break;
            }
        }
        rig.load = 0.0;
        rig.word = None;
        rig.largest_current = 0.0;
        let outputs = rig.run(3_000);
        println!("{velocity} rad/s: {:.1} A", rig.largest_current);
        assert!(outputs.velocity.abs() < 1e-3);
        assert!(rig.largest_current < 8.0, "{}", rig.largest_current);
    }
}

/// Settings are wrong by up to 10 % in flux, and by 20 % in inductance.
#[test]
fn no_random_drive_loses_the_control_of_its_current_at_its_largest_voltage() {
    let mut fast = 0;
    let mut random = Random(31);
    for case in 0..cases(400) {
        if case == cases(400) / 2 {
            random = Random(36);
        }
        let mut drive = Drive::draw(&mut random, 1.0, &[280, 1_024, 4_096]);
        if case % 2 == 1 {
            drive.swap_leads();
        }
        // Up to 1.2 times the speed of the largest voltage; "overspeed" comes at 1.44 times it.
        let base = BASE * GEAR / f64::from(drive.model.gear_ratio);
        drive.velocity = drive.velocity.min(1.2 * base);
        let key = Setting::VelocityLimit.description().key;
        let limit = (drive.velocity * 1e3) as i32;
        drive.settings.set(key, limit).expect("in range");
        let mut rig = drive.rig();
        for step in 0..40 {
            rig.mode = pick(&mut random, &[mode::PROFILE_VELOCITY, mode::CYCLIC_TORQUE]);
            rig.target = if rig.mode == mode::CYCLIC_TORQUE {
                between(&mut random, -1_000.0, 1_000.0) as i32
            } else {
                drive.target(between(&mut random, -1.0, 1.0))
            };
            rig.load = (0.2 * random.next() * drive.torque) as f32;
            for _ in 0..between(&mut random, 5.0, 400.0) as usize {
                let outputs = rig.tick();
                fast += usize::from(outputs.active_limit == ActiveLimit::Voltage);
                if let Some(fault) = outputs.faults.strongest() {
                    assert_ne!(fault, Fault::OverCurrent, "{case} {step}");
                    rig = drive.rig();
                    break;
                }
            }
        }
    }
    println!("{fast} ms at the largest voltage");
    assert!(fast > 25 * cases(400));
}
