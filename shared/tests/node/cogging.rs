//! Tests of the compensation of the cogging torque, on the motor model.

use super::motor_faults::rig::{GEAR, PER_RADIAN, Rig, model, settings};
use crate::sweep::stamp_of_executable;
use tautrack::motor::cogging::Wave;
use tautrack::motor::model::{MotorModel, WindingModel};
use tautrack::node::cogging::{CoggingSearch, SearchState};
use tautrack::settings::{Setting, Settings};

/// Velocity of the search, rad/s of the output shaft: 40 periods per second and more.
const SLOW: f64 = 0.1;

/// A motor with this cogging torque, N m, and this number of periods in a turn of the rotor.
fn cogging(torque: f32, periods: u16) -> MotorModel {
    let mut motor = model(true);
    if let WindingModel::ThreePhase(winding) = &mut motor.winding {
        (winding.cogging_torque, winding.cogging_periods) = (torque, periods);
    }
    motor
}

/// A drive that turns slowly in bench mode, and its search.
fn turning(torque: f32, periods: u16, changes: &[(Setting, i32)]) -> (Rig, CoggingSearch) {
    turning_with_seed(torque, periods, changes, 7)
}

/// The seed draws the noise.
fn turning_with_seed(
    torque: f32,
    periods: u16,
    changes: &[(Setting, i32)],
    seed: u64,
) -> (Rig, CoggingSearch) {
    let mut all = vec![(Setting::CoggingPeriods, i32::from(periods) / 7)];
    all.extend_from_slice(changes);
    let settings = settings(true, &all);
    let mut rig = Rig::with_seed(cogging(torque, periods), &settings, seed);
    rig.bench = true;
    rig.target = (SLOW * PER_RADIAN) as i32;
    rig.run(2_500);
    (rig, CoggingSearch::new(&settings))
}

/// Runs one millisecond of the search.
fn search(rig: &mut Rig, search: &mut CoggingSearch, requested: bool) {
    let outputs = rig.tick();
    let (inputs, position) = (rig.inputs.unwrap(), rig.axle.position());
    if let Some((periods, wave)) = search.tick(requested, &inputs, &outputs, position) {
        rig.current_loop.set_cogging(periods, wave);
    }
}

/// Amplitude of the velocity ripple with the period of the cogging, rad/s, from the model's own
/// position.
fn ripple(rig: &mut Rig, periods: u16) -> f64 {
    let (mut sums, mut last) = ([0.0_f64; 2], rig.angle());
    let milliseconds = 8_000;
    for _ in 0..milliseconds {
        rig.run(1);
        let angle = rig.angle();
        let (sin, cos) = ((angle + last) * 0.5 * GEAR * f64::from(periods)).sin_cos();
        let velocity = (angle - last) * 1e3 - f64::from(rig.target) / PER_RADIAN;
        sums[0] += velocity * cos;
        sums[1] += velocity * sin;
        last = angle;
    }
    2.0 * sums[0].hypot(sums[1]) / f64::from(milliseconds)
}

#[test]
fn a_learned_current_reduces_the_ripple_of_the_velocity_five_times() {
    let Some(_stamp) =
        stamp_of_executable("a_learned_current_reduces_the_ripple_of_the_velocity_five_times")
    else {
        return;
    };
    let absolute: &[_] = &[];
    let incremental = &[(Setting::RotorSensor, 1)][..];
    for (torque, periods, changes) in [
        (0.02, 42, absolute),
        (0.02, 84, absolute),
        (0.01, 42, absolute),
        (0.02, 42, incremental),
    ] {
        let mut worst = (0.0, 0.0);
        for seed in 7..11 {
            let (before, after) = learn(torque, periods, changes, seed);
            assert!(after < before / 5.0, "{seed}");
            if after > worst.1 {
                worst = (before, after);
            }
        }
        let (before, after) = worst;
        println!("{torque} N m, {periods} periods: {before:.4} to {after:.4} rad/s");
    }
}

/// Searches the current of a drive. Returns the ripple before and after, rad/s.
fn learn(torque: f32, periods: u16, changes: &[(Setting, i32)], seed: u64) -> (f64, f64) {
    let (mut rig, mut learner) = turning_with_seed(torque, periods, changes, seed);
    let before = ripple(&mut rig, periods);
    search(&mut rig, &mut learner, true);
    while learner.is_running() {
        search(&mut rig, &mut learner, true);
    }
    let report = *learner.report();
    assert_eq!(report.state, SearchState::Done);
    rig.run(500);
    let after = ripple(&mut rig, periods);
    // The current of the model that cancels its torque, plus what the current loop loses.
    let [cosine, sine] = report.current;
    let amplitude = f64::from(cosine).hypot(f64::from(sine)) * 1e-3;
    assert!((amplitude / (f64::from(torque) / 0.04) - 1.0).abs() < 0.2);

    // The same from the settings, after the next power-up.
    if changes.is_empty() && seed == 7 {
        let changes = [
            (Setting::CoggingCosine, cosine),
            (Setting::CoggingSine, sine),
        ];
        let mut all = changes.to_vec();
        all.push((Setting::CoggingPeriods, i32::from(periods) / 7));
        let (mut rig, _) = turning(torque, periods, &changes);
        let (periods_of_settings, wave) = tautrack::node::cogging::stored(&settings(true, &all));
        rig.current_loop.set_cogging(periods_of_settings, wave);
        rig.run(500);
        assert!(ripple(&mut rig, periods) < before / 5.0);
    }
    (before, after)
}

#[test]
fn a_search_ends_when_the_shaft_does_not_turn_or_nobody_may() {
    // Without a request, and without bench mode.
    let (mut rig, mut learner) = turning(0.02, 42, &[]);
    for _ in 0..6_000 {
        search(&mut rig, &mut learner, true);
    }
    assert!(learner.is_running());
    search(&mut rig, &mut learner, false);
    assert_eq!(learner.report().state, SearchState::Failed);
    rig.bench = false;
    rig.run(100);
    search(&mut rig, &mut learner, true);
    assert_eq!(learner.report().state, SearchState::Failed);
    // A shaft that stands has no ripple that a current changes.
    let (mut rig, mut learner) = turning(0.02, 42, &[]);
    rig.target = 0;
    rig.run(1_000);
    search(&mut rig, &mut learner, true);
    while learner.is_running() {
        search(&mut rig, &mut learner, true);
    }
    assert_eq!(learner.report().state, SearchState::Failed);
    // Without the number of periods.
    let mut learner = CoggingSearch::new(&Settings::default());
    search(&mut rig, &mut learner, true);
    assert_eq!(learner.report().state, SearchState::Failed);
}

#[test]
fn no_wave_lifts_a_current_above_the_limit() {
    // A wave of 6 A, and a blocked shaft that draws the limit of 10 A.
    let mut largest = 0.0_f64;
    for cosine in [6.0, -6.0] {
        for sine in [0.0, 3.0] {
            let mut motor = cogging(0.0, 42);
            motor.friction_torque = 100.0;
            let mut rig = Rig::with_model(motor, &settings(true, &[]));
            rig.current_loop.set_cogging(6, Wave { cosine, sine });
            for direction in [1.0, -1.0] {
                rig.target = (direction * 5.0 * PER_RADIAN) as i32;
                rig.until_fault(500).expect("blocked");
                rig.reset = true;
                while !rig.tick().faults.is_empty() {}
                rig.reset = false;
            }
            largest = largest.max(rig.largest_current);
        }
    }
    println!("{largest} A");
    assert!(largest < 10.5, "{largest} A");
}
