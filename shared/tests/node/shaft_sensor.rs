//! An axle whose position a sensor at its output shaft has given, while it runs.

use crate::fault_times::located;
use crate::motor_faults::rig::PER_RADIAN;
use tautrack::faults::Fault;

/// Runs at this speed and this difference, degrees. Returns the faults.
fn faults(three_phase: bool, speed: f64, degrees: f64) -> Option<Fault> {
    let mut rig = located(three_phase);
    rig.target = (speed * PER_RADIAN) as i32;
    rig.run(1_000);
    rig.shaft_error = Some(degrees.to_radians());
    let raised = rig.until_raised(1_000)?;
    raised.0.faults.strongest()
}

#[test]
fn a_shaft_sensor_and_an_encoder_that_drift_apart_are_a_fault_at_any_speed() {
    for three_phase in [false, true] {
        for speed in [0.0, 0.3, -3.0, 5.5] {
            // An angle is late by up to 13 ms, which counts for the sensor.
            let late = (0.013 * f64::abs(speed)).to_degrees();
            for sign in [1.0, -1.0] {
                let found = |degrees: f64| faults(three_phase, speed, sign * degrees);
                let what = format!("{three_phase} {speed} {sign}");
                assert_eq!(found(4.5), None, "{what}");
                let apart = found(5.5 + 2.0 * late);
                assert_eq!(apart, Some(Fault::ShaftMismatch), "{what}");
            }
        }
    }
}

#[test]
fn no_motion_of_a_sound_drive_is_a_drift() {
    for three_phase in [false, true] {
        let mut rig = located(three_phase);
        for speed in [5.5, -5.5, 0.0, 3.0, 0.1, -0.1] {
            rig.target = (speed * PER_RADIAN) as i32;
            rig.run(2_000);
        }
    }
}
