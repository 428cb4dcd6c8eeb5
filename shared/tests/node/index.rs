//! Tests of the encoder's index, on the motor model: an incremental encoder that gives a pulse in
//! each turn of the rotor.

use super::motor_faults::rig::{GEAR, PER_RADIAN, Rig, Trouble, model, settings};
use crate::random::Random;
use crate::sweep::stamp_of_executable;
use std::f64::consts::TAU;
use tautrack::faults::{Fault, Faults};
use tautrack::motor::model::{MotorModel, WindingModel};
use tautrack::node::axle::AlignmentState;
use tautrack::settings::Setting;

const COUNTS: f64 = 4_096.0;
/// Electrical degrees per count.
const PER_COUNT: f64 = 7.0 * 360.0 / COUNTS;
/// Electrical angle of the model at the pulse, degrees.
const OFFSET: f64 = 40.0;

/// A drive with an index whose calibrated angle is wrong by `error`, electrical degrees. The seed
/// draws the angle at which the rotor stands.
fn rig(error: f64, seed: u64) -> Rig {
    rig_with_friction(error, seed, 0.5)
}

/// The same with this friction, N m.
fn rig_with_friction(error: f64, seed: u64, friction_torque: f32) -> Rig {
    let model = MotorModel {
        friction_torque,
        ..model(true)
    };
    let changes = [
        (Setting::RotorSensor, 3),
        (Setting::ElectricalOffset, ((OFFSET + error) * 1e3) as i32),
    ];
    Rig::with_seed(model, &settings(true, &changes), seed)
}

/// Runs until the drive follows its set-points.
fn arm(rig: &mut Rig) {
    rig.word = None;
    for _ in 0..3_000 {
        let alignment = rig.run(1).alignment;
        if matches!(alignment, AlignmentState::Done | AlignmentState::Confirmed) {
            return;
        }
    }
    panic!("it does not align");
}

/// Sets the speed as a multiple of a rad/s.
fn turn(rig: &mut Rig, speed: f64) {
    rig.target = (speed * PER_RADIAN) as i32;
}

/// Time of a turn of the rotor, ms.
fn turn_ms(speed: f64) -> usize {
    (1e3 * TAU / (speed.abs() * GEAR)) as usize
}

/// Error of the rotor's angle at standstill, electrical degrees.
fn error_degrees(rig: &mut Rig) -> f64 {
    let inputs = rig.inputs.expect("a tick");
    let shown = f64::from(inputs.electrical.angle.expect("an angle").0.degrees());
    let truth = f64::from(rig.motor.readings().rotor) * PER_COUNT + OFFSET;
    (shown - truth + 180.0).rem_euclid(360.0) - 180.0
}

#[test]
fn the_first_pulse_replaces_the_aligned_angle_by_the_calibrated_one() {
    let (mut aligned, mut corrected) = (0.0_f64, 0.0_f64);
    for seed in 1..=24 {
        // A quarter of the torque of the alignment's 3 A shifts the angle by 14 degrees. The
        // friction holds the shaft until then.
        let mut rig = rig_with_friction(0.0, seed, 2.0);
        rig.load = 1.8;
        arm(&mut rig);
        rig.load = 0.0;
        rig.run(20);
        aligned = aligned.max(error_degrees(&mut rig).abs());
        turn(&mut rig, if seed % 2 == 0 { 1.0 } else { -1.0 });
        rig.run(2 * turn_ms(1.0) + 300);
        turn(&mut rig, 0.0);
        let outputs = rig.run(400);
        assert_eq!(outputs.alignment, AlignmentState::Confirmed);
        corrected = corrected.max(error_degrees(&mut rig).abs());
    }
    println!("{aligned:.1} degrees, then {corrected:.1} degrees");
    assert!(aligned > 10.0 && corrected < 1.0);
}

#[test]
fn a_wrong_calibrated_angle_is_found_at_the_first_pulse() {
    for (error, found) in [(10.0, false), (-10.0, false), (30.0, true), (-90.0, true)] {
        for seed in 1..=8 {
            let mut rig = rig(error, seed);
            arm(&mut rig);
            turn(&mut rig, if seed % 2 == 0 { 1.0 } else { -1.0 });
            let raised = rig.until_fault(2 * turn_ms(1.0) + 300);
            let faults = raised.map(|(outputs, ..)| outputs.faults);
            let expected = found.then_some(Faults::of(Fault::Misaligned));
            assert_eq!(faults, expected, "{error} degrees");
        }
    }
}

#[test]
fn lost_counts_are_found_within_a_turn_of_the_rotor() {
    let mut random = Random(91);
    let (mut latest, mut others) = (0.0_f64, 0);
    for case in 0..120 {
        // 585 counts are an electrical turn, which leaves the torque right.
        let lost = [12, -12, 30, -100, 585, -1_170, 400, -2_000][case % 8];
        let speed = (0.5 + 2.0 * random.next().abs()) * if case % 4 < 2 { 1.0 } else { -1.0 };
        let mut rig = rig(0.0, case as u64 + 1);
        rig.index_width = (case % 5) as i32;
        arm(&mut rig);
        turn(&mut rig, speed);
        rig.run(600 + 2 * turn_ms(speed) + case);
        rig.trouble = Trouble::LostCounts(lost);
        let (outputs, milliseconds, _) = rig.until_fault(1_000).expect("a fault");
        // 30 lost counts make an angle of 18 degrees, which other watches may find first.
        let by_index = outputs.faults == Faults::of(Fault::EncoderNoise);
        assert!(by_index || lost.abs() > 12, "{lost}: {:?}", outputs.faults);
        others += usize::from(!by_index);
        latest = latest.max(milliseconds as f64 / turn_ms(speed) as f64);
    }
    println!("after {latest:.2} turns at most; {others} found by other watches");
    assert!(latest < 1.1);
}

#[test]
fn an_index_without_pulses_is_found_within_a_turn_of_the_rotor() {
    for speed in [0.3, -0.3, 2.0, -5.0] {
        for works_first in [false, true] {
            let mut rig = rig(0.0, 5);
            rig.index = works_first;
            arm(&mut rig);
            turn(&mut rig, speed);
            let mut milliseconds = 0;
            if works_first {
                rig.run(400 + 2 * turn_ms(speed));
                rig.index = false;
            }
            let start = rig.angle();
            while rig.tick().faults.is_empty() {
                milliseconds += 1;
                assert!(milliseconds < 3_000, "{speed}");
            }
            let turns = (rig.angle() - start).abs() * GEAR / TAU;
            println!("{speed} rad/s: {turns:.2} turns");
            assert!(turns < 1.1);
            let faults = rig.tick().faults;
            assert_eq!(faults, Faults::of(Fault::EncoderNoise));
        }
    }
}

/// Loads, speeds, disarmed drives whose shafts something turns, and pulses with a width.
#[test]
fn a_sound_encoder_is_not_accused() {
    let Some(_stamp) = stamp_of_executable("a_sound_encoder_is_not_accused") else {
        return;
    };
    let mut random = Random(92);
    for case in 0..40 {
        let mut rig = rig_with_friction(0.0, case + 1, 0.2);
        rig.index_width = (case % 5) as i32;
        // Pulses before the alignment count for nothing.
        rig.word = Some(0);
        for step in 0..30 {
            let disarmed = step % 5 == 0;
            rig.load = (8.0 * random.next()) as f32;
            if disarmed {
                rig.word = Some(0);
                rig.load *= 0.2;
            } else {
                if step % 5 == 1 {
                    (rig.load, rig.word) = (0.0, Some(0));
                    // The shaft comes to rest, and the drive is armed again.
                    rig.run(1_500);
                    arm(&mut rig);
                }
                turn(&mut rig, 5.0 * random.next());
            }
            for _ in 0..200 {
                let outputs = rig.tick();
                assert!(
                    outputs.faults.is_empty(),
                    "{case} {step}: {:?}",
                    outputs.faults
                );
            }
        }
        assert_eq!(rig.tick().alignment, AlignmentState::Confirmed, "{case}");
    }
}

#[test]
fn the_angle_is_right_with_other_windings_and_swapped_leads() {
    // With the leads a and b swapped, the angle in the stator is 120 degrees minus the true one.
    for (offset, shown, reversed) in [
        (0.0, 0.0, false),
        (170.0, 170.0, false),
        (-30.0, 150.0, true),
    ] {
        let mut model = model(true);
        if let WindingModel::ThreePhase(winding) = &mut model.winding {
            winding.offset_degrees = offset;
        }
        let mut rig = Rig::with_seed(
            model,
            &settings(
                true,
                &[
                    (Setting::RotorSensor, 3),
                    (Setting::PhaseOrder, if reversed { -1 } else { 1 }),
                    (Setting::ElectricalOffset, (shown * 1e3) as i32),
                ],
            ),
            3,
        );
        arm(&mut rig);
        turn(&mut rig, 2.0);
        rig.load = 8.0;
        let outputs = rig.run(900);
        assert_eq!(outputs.alignment, AlignmentState::Confirmed);
        let current = f64::from(outputs.status.current) * 1e-3;
        let ideal = (8.0 + 0.5) / (0.04 * GEAR);
        assert!(
            (current / ideal - 1.0).abs() < 0.06,
            "{current} A, {ideal} A"
        );
    }
}
