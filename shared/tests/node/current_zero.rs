//! The zero of the current converters, which is followed while the bridge is open.

use super::motor_faults::rig::{Rig, STAGE, Trouble, model, settings};
use super::motor_faults::wrong_angle::{Drive, between};
use crate::random::Random;
use crate::sweep::stamp_of_executable;
use tautrack::bus::cia402::CONTROL_FAULT_RESET;
use tautrack::faults::{Fault, Faults};
use tautrack::motor::current::ZERO_ERROR;
use tautrack::motor::model::MotorModel;
use tautrack::node::axle::{BridgeDemand, Outputs};

/// Current limit of the drives, A.
const LIMIT: f64 = 10.0;

/// Runs milliseconds in which faults may come. Returns the outputs of the last one.
fn run(rig: &mut Rig, milliseconds: usize) -> Outputs {
    for _ in 1..milliseconds {
        rig.tick();
    }
    rig.tick()
}

/// Makes a drive whose converter of this half bridge shows a current, A, while none flows. Its
/// master leaves it without power for 100 ms, and then arms it.
fn armed(three_phase: bool, phase: usize, amperes: f64) -> Rig {
    with_offset(Rig::new(three_phase, &[]), phase, amperes)
}

/// The converter of this half bridge shows a current, A, while none flows.
fn offset(phase: usize, amperes: f64) -> Trouble {
    let codes = amperes / f64::from(STAGE.full_scale) * 32_768.0;
    Trouble::CurrentOffset(phase, codes as i32)
}

/// Gives this drive such a converter.
fn with_offset(mut rig: Rig, phase: usize, amperes: f64) -> Rig {
    rig.trouble = offset(phase, amperes);
    rig.word = Some(0);
    assert_eq!(rig.run(100).faults, Faults::NONE, "no fault before arming");
    rig.word = None;
    rig
}

#[test]
fn a_drive_whose_current_reads_more_than_its_bound_without_power_gets_none() {
    let bound = 0.02 * LIMIT + f64::from(ZERO_ERROR * STAGE.full_scale);
    let mut random = Random(91);
    for case in 0..400 {
        let three_phase = case % 2 == 1;
        let phase = if three_phase { case / 2 % 2 } else { 0 };
        let sign = if case % 8 < 4 { 1.0 } else { -1.0 };
        let part = between(&mut random, 0.0, 3.0);
        let mut rig = armed(three_phase, phase, sign * part * bound);
        let context = format!("{case}: {part} of the bound");
        // The converter is noisy.
        if part < 1.05 {
            if part < 0.95 {
                assert_eq!(rig.run(50).faults, Faults::NONE, "{context}");
                assert!(rig.is_enabled(), "{context}");
            }
            continue;
        }
        let accused = Faults::of(Fault::InvalidReading);
        loop {
            let outputs = rig.tick();
            let drives = !matches!(outputs.bridge, BridgeDemand::Off | BridgeDemand::Brake);
            assert!(!drives, "{context}: {:?}", outputs.bridge);
            if outputs.faults == accused {
                break;
            }
            assert!(rig.now_us < 200_000, "{context}");
        }
        // A reset clears it, so that a calibration can find the zero. The next arming accuses
        // again.
        for word in [0, CONTROL_FAULT_RESET, 0] {
            rig.word = Some(word);
            run(&mut rig, 50);
        }
        assert_eq!(rig.tick().faults, Faults::NONE, "{context}");
        rig.word = None;
        assert_eq!(run(&mut rig, 100).faults, accused, "{context}");
    }
}

#[test]
fn the_second_converter_of_a_brushed_motor_must_agree_with_the_first() {
    // Within 20 % of 10 A, and 2 % of 160 A. A zero of its own is followed before the arming.
    let mut rig = armed(false, 1, 6.5);
    assert_eq!(rig.run(200).faults, Faults::NONE);
    rig.trouble = offset(1, 10.5);
    assert_eq!(rig.run(200).faults, Faults::NONE);
    assert!(rig.is_enabled());
    rig.trouble = offset(1, 13.0);
    let (outputs, milliseconds) = rig.until_raised(200).expect("a fault");
    assert_eq!(outputs.faults.strongest(), Some(Fault::InvalidReading));
    println!("{milliseconds} ms");
}

/// The generated voltage exceeds that of the supply, so that current flows through the diodes.
#[test]
fn a_shaft_that_something_turns_is_not_accused_of_its_current() {
    for three_phase in [false, true] {
        let mut rig = Rig::new(three_phase, &[]);
        rig.supply_voltage = 12.5;
        rig.load = -8.0;
        rig.word = Some(0);
        let mut largest = 0.0_f32;
        for _ in 0..1_000 {
            rig.run(1);
            let current = rig.inputs.map(|inputs| inputs.current);
            largest = largest.max(current.expect("a tick").abs());
        }
        assert!(f64::from(largest) > 0.05 * LIMIT, "{largest} A");
        rig.word = None;
        for _ in 0..300 {
            let faults = rig.tick().faults;
            assert!(!faults.contains(Fault::InvalidReading), "{three_phase}");
        }
    }
}

/// Before the zero was followed, such drives were accused of a wrong rotor angle.
#[test]
fn a_drive_whose_zero_is_wrong_by_less_than_the_bound_is_not_accused() {
    let Some(_stamp) =
        stamp_of_executable("a_drive_whose_zero_is_wrong_by_less_than_the_bound_is_not_accused")
    else {
        return;
    };
    let mut random = Random(12);
    for part in [0.005, 0.01, 0.02, 0.03] {
        for case in 0..60 {
            let drive = Drive::draw(&mut random, 1.0, &[280, 1_024, 4_096]);
            let amperes = if case % 2 == 0 { part } else { -part } * LIMIT;
            let mut rig = with_offset(drive.rig(), case / 2 % 2, amperes);
            for step in 0..40 {
                rig.target = drive.target(between(&mut random, -0.3, 0.3));
                rig.load = (0.5 * random.next() * drive.torque) as f32;
                for _ in 0..100 {
                    let fault = rig.tick().faults.strongest();
                    assert_eq!(fault, None, "{part}: {case} {step}");
                }
            }
        }
    }
}

/// Returns the mean currents of half bridges a and b, A, at a torque of 0.3 of the full one, of a
/// drive that is armed with this error of a converter's zero, A. Its shaft is held.
fn held(three_phase: bool, phase: usize, amperes: f64) -> [f64; 2] {
    let held = MotorModel {
        friction_torque: 30.0,
        ..model(three_phase)
    };
    let rig = Rig::with_model(held, &settings(three_phase, &[]));
    let mut rig = with_offset(rig, phase, amperes);
    (rig.mode, rig.target) = (10, 300);
    rig.run(200);
    let mut sums = [0.0; 2];
    for _ in 0..200 {
        assert_eq!(rig.tick().faults, Faults::NONE);
        for (sum, code) in sums.iter_mut().zip(rig.motor.readings().currents) {
            *sum += (f64::from(code) - 32_768.0) / 32_768.0 * f64::from(STAGE.full_scale);
        }
    }
    sums.map(|sum| sum / 200.0)
}

#[test]
fn a_zero_that_has_drifted_before_an_arming_does_not_change_the_current() {
    for (three_phase, phase) in [(false, 0), (true, 0), (true, 1)] {
        let sound = held(three_phase, phase, 0.0);
        assert!(sound[0].hypot(sound[1]) > 1.0, "{sound:?}");
        for part in [-0.02, -0.01, 0.005, 0.02] {
            let drifted = held(three_phase, phase, part * LIMIT);
            for (drifted, sound) in drifted.into_iter().zip(sound) {
                let error = (drifted - sound).abs();
                // One code is 0.05 % of the limit.
                assert!(
                    error < 0.001 * LIMIT,
                    "{three_phase} {phase} {part}: {error} A"
                );
            }
        }
    }
}
