//! Calibrates simulated motors that are drawn at random.

mod bench;

use crate::parallel;
use crate::random::Random;
use crate::sweep::{cases, stamp_of_executable};
use bench::{Bench, PERIODS, SUPPLY, Truth, draw, plan};
use tautrack::link::{MotorModel, ThreePhaseModel, WindingModel};
use tautrack::motor::calibration::{Plan, Quantity, Record, Refusal};
use tautrack::motor::current::{BridgeDemand, Config};
use tautrack::motor::rotor::RotorSensor;

fn off(got: f32, truth: f32) -> f64 {
    (f64::from(got) / f64::from(truth) - 1.0).abs()
}

/// Largest errors of a set of calibrations.
#[derive(Debug, Default)]
struct Worst {
    resistance: f64,
    inductance: f64,
    torque_constant: f64,
    offset_degrees: f64,
    seconds: f64,
    current: f64,
    torque_before: f64,
    torque_after: f64,
}

#[test]
fn random_three_phase_motors_are_measured_or_refused_with_the_reason() {
    let Some(_stamp) =
        stamp_of_executable("random_three_phase_motors_are_measured_or_refused_with_the_reason")
    else {
        return;
    };
    let mut random = Random(20_261_123);
    let motors = (0..cases(50) as u64).map(|number| (number, draw(&mut random, false)));
    let (worst, refused) = measure(motors.collect(), [0.05, 0.10, 0.03, 2.0]);
    println!("{refused} three-phase motors refused; {worst:?}");
    assert!(refused <= cases(5), "{refused}");
    assert!(worst.torque_before > 0.08, "{worst:?}");
    // Steps and noise of the converter, and the swing of the rotor.
    assert!(worst.current <= 2.0, "{}", worst.current);
}

#[test]
fn random_motors_with_hall_sensors_are_measured_or_refused_with_the_reason() {
    let Some(_stamp) = stamp_of_executable(
        "random_motors_with_hall_sensors_are_measured_or_refused_with_the_reason",
    ) else {
        return;
    };
    let mut random = Random(20_261_126);
    let motors = (0..cases(50) as u64).map(|number| {
        let truth = Truth {
            halls: Some([(); 3].map(|()| 5.0 * random.next())),
            ..draw(&mut random, false)
        };
        (number, truth)
    });
    // While it stands, the rotor's angle is wrong by up to 30 degrees, so that the axes are mixed.
    let (worst, refused) = measure(motors.collect(), [0.05, 0.20, 0.045, 7.0]);
    println!("{refused} motors with Hall sensors refused; {worst:?}");
    assert!(refused <= cases(8), "{refused}");
    assert!(worst.current <= 2.0, "{}", worst.current);
}

/// Calibrates three-phase motors, and checks the records against the largest errors of resistance,
/// inductances and torque constant, as fractions, and of the offset, degrees. Returns the errors,
/// and how many motors were refused.
fn measure(motors: Vec<(u64, Truth)>, bounds: [f64; 4]) -> (Worst, usize) {
    let (mut worst, mut refused) = (Worst::default(), 0);
    let results = parallel::map(&motors, |(number, truth)| {
        let mut bench = Bench::new(truth, &truth.config(None), *number);
        let (result, seconds) = bench.calibrate(&plan(truth));
        let record = result.as_ref().ok();
        let torque_errors =
            record.map(|record| [None, Some(record)].map(|record| torque_error(truth, record)));
        (result, seconds, bench.largest_current, torque_errors)
    });
    for ((number, truth), (result, seconds, largest_current, torque_errors)) in
        motors.into_iter().zip(results)
    {
        let winding = truth.three_phase();
        worst.current = worst
            .current
            .max(largest_current / f64::from(truth.calibration_current));
        worst.seconds = worst.seconds.max(seconds);
        let record = match result {
            Ok(record) => record,
            Err(refusal) => {
                println!("motor {number} refused after {seconds} s: {refusal}\n  {truth:?}");
                refused += 1;
                continue;
            }
        };
        let about = format!("motor {number}: {record:?}\n{truth:?}");
        assert_eq!(record.pole_pairs, i32::from(winding.pole_pairs), "{about}");
        assert_eq!(record.reversed, truth.swapped, "{about}");
        let resistance = off(record.resistance, winding.resistance);
        let inductance = [0, 1]
            .map(|axis| off(record.inductance[axis], winding.inductance[axis]))
            .into_iter()
            .fold(0.0, f64::max);
        let torque_constant = off(
            record.torque_constant.expect("the shaft was free"),
            truth.model.winding.torque_constant(),
        );
        let apart = offset_error(&truth, &record);
        worst.resistance = worst.resistance.max(resistance);
        worst.inductance = worst.inductance.max(inductance);
        worst.torque_constant = worst.torque_constant.max(torque_constant);
        worst.offset_degrees = worst.offset_degrees.max(apart.abs());
        let errors = [resistance, inductance, torque_constant, apart.abs()];
        let good = errors
            .iter()
            .zip(&bounds)
            .all(|(error, bound)| error <= bound);
        assert!(good, "{errors:?} {about}");
        let [before, after] = torque_errors.expect("for a record");
        // A rotor that stands between the edges of Hall sensors has an angle wrong by 30 degrees.
        assert!(truth.halls.is_some() || after <= 0.03, "{after} {about}");
        worst.torque_before = worst.torque_before.max(before);
        worst.torque_after = worst.torque_after.max(after);
    }
    (worst, refused)
}

/// Degrees by which the offset of a record is wrong.
fn offset_error(truth: &Truth, record: &Record) -> f64 {
    let degrees = f64::from(record.offset.0.degrees());
    (degrees - truth.offset_degrees() + 540.0).rem_euclid(360.0) - 180.0
}

#[test]
fn with_an_index_the_offset_is_the_angle_at_its_pulse() {
    let Some(_stamp) = stamp_of_executable("with_an_index_the_offset_is_the_angle_at_its_pulse")
    else {
        return;
    };
    let mut random = Random(9);
    let (mut worst, mut measured, mut missing) = (0.0_f64, 0, 0);
    for number in 0..8 {
        let truth = Truth {
            sensor_noise: false,
            ..draw(&mut random, false)
        };
        let config = Config {
            sensor: RotorSensor::Indexed,
            ..truth.config(None)
        };
        for connected in [true, false] {
            // The seed draws the angle at power-up.
            let mut bench = Bench::new(&truth, &config, number);
            bench.incremental = connected;
            let (result, _) = bench.calibrate(&Plan {
                index: true,
                ..plan(&truth)
            });
            match result {
                Ok(record) if connected => {
                    let error = offset_error(&truth, &record).abs();
                    // The edges of the counts are anywhere between those of the absolute counts.
                    let per_turn = truth.model.encoder_counts as f32;
                    let count = 360.0 * f32::from(truth.three_phase().pole_pairs) / per_turn;
                    worst = worst.max(error - f64::from(count));
                    measured += 1;
                }
                Err(Refusal::OutOfBounds {
                    quantity: Quantity::IndexPulses,
                    ..
                }) if !connected => missing += 1,
                // A motor that a calibration without an index refuses, too.
                Err(Refusal::Timeout { .. }) => {}
                other => panic!("{number} {connected}: {other:?}"),
            }
        }
    }
    println!("{measured} and {missing} of 8; {worst:.1} degrees and a count");
    assert!(worst <= 2.0 && measured >= 6 && missing >= 6);
}

/// Largest error of the mean torque from 10 to 97 % of the current limit, before a calibration to
/// 85 %, as a fraction. The rotor is so heavy that it stands at random angles.
fn torque_error(truth: &Truth, record: Option<&Record>) -> f64 {
    let winding = match truth.model.winding {
        WindingModel::ThreePhase(winding) => WindingModel::ThreePhase(ThreePhaseModel {
            cogging_torque: 0.0,
            ..winding
        }),
        brushed @ WindingModel::Brushed { .. } => brushed,
    };
    let inertia = 10.0;
    let heavy = Truth {
        model: MotorModel {
            winding,
            rotor_inertia: inertia,
            gear_ratio: 1.0,
            friction_torque: 0.0,
            ..truth.model
        },
        ..*truth
    };
    let config = Config {
        gear_ratio: 1.0,
        ..heavy.config(record)
    };
    let constant = f64::from(truth.model.winding.torque_constant());
    let error = |part: f64| {
        let wanted = part * constant * f64::from(truth.current_limit);
        let angles = 4;
        let torques = (0..angles).map(|seed| {
            let mut bench = Bench::new(&heavy, &config, 77 + seed);
            bench
                .current_loop
                .set_sensing(record.map(|record| record.sensing).unwrap_or_default());
            let amperes = wanted / f64::from(config.torque_constant);
            let mut run = |periods: u32| {
                for period in 0..periods {
                    if period % PERIODS == 0 {
                        let demand = BridgeDemand::Current(amperes as f32);
                        bench.current_loop.demand(demand, SUPPLY, 0.0);
                    }
                    bench.period();
                }
                f64::from(bench.motor.shaft().velocity)
            };
            let before = run(1_000);
            let after = run(1_000);
            inertia as f64 * (after - before) / 0.05 / wanted
        });
        (torques.sum::<f64>() / angles as f64 - 1.0).abs()
    };
    // A torque constant that is too small demands more current than the limit for the full torque.
    let most = if record.is_some() { 0.97 } else { 0.85 };
    [0.1, 0.3, most].into_iter().map(error).fold(0.0, f64::max)
}

#[test]
fn random_brushed_motors_are_measured_or_refused_with_the_reason() {
    let mut random = Random(20_261_124);
    let (mut worst, mut refused) = (Worst::default(), 0);
    for number in 0..cases(50) as u64 {
        let truth = draw(&mut random, true);
        let WindingModel::Brushed {
            resistance,
            inductance,
            torque_constant,
        } = truth.model.winding
        else {
            unreachable!("a brushed motor")
        };
        let mut bench = Bench::new(&truth, &truth.config(None), number);
        let (result, seconds) = bench.calibrate(&plan(&truth));
        worst.current = worst
            .current
            .max(bench.largest_current / f64::from(truth.calibration_current));
        worst.seconds = worst.seconds.max(seconds);
        let record = match result {
            Ok(record) => record,
            Err(refusal) => {
                println!("motor {number} refused after {seconds} s: {refusal}\n  {truth:?}");
                refused += 1;
                continue;
            }
        };
        let about = format!("motor {number}: {record:?}\n{truth:?}");
        let resistance = off(record.resistance, resistance);
        let inductance = off(record.inductance[0], inductance);
        let found = record.torque_constant.expect("the shaft was free");
        let torque_constant = off(found, torque_constant);
        worst.resistance = worst.resistance.max(resistance);
        worst.inductance = worst.inductance.max(inductance);
        worst.torque_constant = worst.torque_constant.max(torque_constant);
        assert!(resistance <= 0.05, "{about}");
        assert!(inductance <= 0.10, "{about}");
        assert!(torque_constant <= 0.03, "{about}");
    }
    println!("{refused} brushed motors refused; {worst:?}");
    // Coarse encoders and heavy rotors, whose resistance has too large a standard error.
    assert!(refused <= cases(8), "{refused}");
    assert!(worst.current <= 2.0, "{}", worst.current);
}

#[test]
fn any_zero_between_25_and_75_percent_of_the_range_is_found() {
    let mut random = Random(20_261_129);
    for brushed in [false, true] {
        // The first motor whose currents fit into the shorter half of the range.
        let truth = loop {
            let truth = draw(&mut random, brushed);
            if truth.current_limit < 12.0 {
                break truth;
            }
        };
        let calibrate = |zero: [i32; 2]| {
            let truth = Truth { zero, ..truth };
            let mut bench = Bench::new(&truth, &truth.config(None), 1);
            bench.calibrate(&plan(&truth)).0
        };
        for zero in [
            [-16_200, -16_100],
            [-8_081, -8_081],
            [0, 16_200],
            [16_100, 9_000],
        ] {
            let record = calibrate(zero).unwrap_or_else(|refusal| panic!("{zero:?}: {refusal}"));
            for (found, true_zero) in record.sensing.zero.into_iter().zip(zero) {
                let error = found - 32_768 - true_zero;
                // A step of the converter is 32 codes.
                assert!(error.abs() <= 40, "{zero:?}: {error}");
            }
        }
        for zero in [[-16_600, 0], [0, 16_600]] {
            let refusal = calibrate(zero).expect_err("a zero at the end of the range");
            let wrong_zero = Quantity::CurrentZero;
            assert!(
                matches!(refusal, Refusal::OutOfBounds { quantity, .. } if quantity == wrong_zero),
                "{zero:?}: {refusal}"
            );
        }
    }
}
