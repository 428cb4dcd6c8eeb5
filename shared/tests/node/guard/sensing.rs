//! Tests of how far the guard believes its sensors and its settings.

use super::bench::{Bench, standing, verdict};
use tautrack::node::guard::State;
use tautrack::sensing::trust::{Reason, Trust};
use tautrack::sensors::{BodySensors, Fresh, Sensor};
use tautrack::settings::Setting;
use tautrack::stability::filter::Verdict;
use tautrack::stability::parameters::Refusal;
use tautrack::stability::support::Edge;
use tautrack::stability::trip::Cause;

#[test]
fn sensors_that_are_no_numbers_stop_the_robot() {
    let mut bench = Bench::armed();
    bench.ask(130);
    bench.run(1_000);
    bench.body = Some(standing(f32::NAN));
    let outputs = bench.run(500);
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (0, Some(Verdict::Blind(Reason::NotFinite)))
    );
    bench.body = None;
    let outputs = bench.run(500);
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (0, Some(Verdict::Blind(Reason::Silent)))
    );
}

#[test]
fn an_attitude_that_the_accelerometer_denies_slows_the_robot_and_then_stops_it() {
    let mut bench = Bench::armed();
    bench.ask(130);
    bench.run(1_000);
    // The inclinometer has come loose.
    bench.body = Some(BodySensors {
        inclination: [-0.4, 0.0],
        ..standing(0.0)
    });
    let (mut slowed, mut stopped) = (false, false);
    for _ in 0..6_000 {
        let outputs = bench.tick();
        slowed |= verdict(&outputs) == Some(Verdict::Doubted(Reason::Disagreement))
            && outputs.passed.passed_speed == 50;
        stopped |= outputs.passed.passed_speed == 0;
    }
    assert!(slowed && stopped);
    let known = bench.guard.telemetry();
    assert_eq!(known.trust, Trust::None(Reason::Disagreement));
    assert_eq!(
        known.snapshot.map(|kept| kept.cause),
        Some(Cause::Sensors(Reason::Disagreement))
    );
}

#[test]
fn settings_that_make_no_sense_are_not_armed() {
    let bench = Bench::with(&[(Setting::StopMargin, 95_000)]);
    assert!(matches!(
        bench.guard.telemetry().refusal,
        Some(Refusal::Levels { .. })
    ));
    // A payload that would put the centre of gravity behind the rear edge.
    let mut bench = Bench::with(&[
        (Setting::PayloadMass, 20_000),
        (Setting::PayloadForward, -200_000),
    ]);
    let refusal = bench.guard.telemetry().refusal;
    assert!(
        matches!(refusal, Some(Refusal::CogOutside { edge: Edge::Back, margin }) if margin < 0.0),
        "{refusal:?}"
    );
    let outputs = bench.run(1_000);
    assert_eq!(State::from_code(outputs.state.state), Some(State::Ready));
}

#[test]
fn an_undeclared_load_narrows_every_margin_by_what_it_can_do() {
    let margins = |mass| {
        let mut bench = Bench::with(&[(Setting::MassUncertainty, mass)]);
        bench.run(100).margins
    };
    let (without, with) = (margins(0), margins(1_000));
    // 1 kg, 0.3 m away, of then 9.315 kg shifts the centre of gravity by 32 mm.
    for (before, after) in [(without.back, with.back), (without.left, with.left)] {
        assert!((before - after - 32).abs() <= 1, "{without:?} {with:?}");
    }
}

/// Settings of sensors that measure 50 times per second.
const SLOW_SENSORS: &[(Setting, i32)] =
    &[(Setting::InertialRate, 50), (Setting::InclinometerRate, 50)];

/// Runs `ticks` with a new reading in every `period` ms.
fn measure(bench: &mut Bench, period: u64, ticks: u64) -> tautrack::node::guard::Outputs {
    for _ in 0..ticks {
        let step = bench.now_us / 1_000;
        // Noise that differs between two readings in a row.
        let noise = 1e-4 * ((step / period) % 3) as f32;
        let [x, y, z] = standing(0.0).specific_force;
        bench.body = Some(BodySensors {
            specific_force: [x + noise, y + noise, z + noise],
            angular_rate: [noise; 3],
            fresh: if step.is_multiple_of(period) {
                Fresh::ALL
            } else {
                Fresh::NONE
            },
            ..standing(0.0)
        });
        bench.tick();
    }
    bench.guard.outputs().clone()
}

#[test]
fn a_robot_whose_sensors_measure_at_50_hz_drives_as_commanded() {
    let mut bench = Bench::with(SLOW_SENSORS);
    bench.ask(130);
    let outputs = measure(&mut bench, 20, 5_000);
    assert_eq!(bench.guard.telemetry().trust, Trust::Full);
    assert_eq!(outputs.passed.passed_speed, 130);
    for sensor in [
        Sensor::Inclinometer,
        Sensor::Accelerometer,
        Sensor::Gyroscope,
    ] {
        let state = bench.guard.sensor(sensor);
        assert!(
            state.health == 0 && state.rate.abs_diff(500) <= 5,
            "{sensor:?}: {state:?}"
        );
    }
}

#[test]
fn sensors_at_half_of_their_rate_are_doubted_and_the_robot_crawls() {
    let mut bench = Bench::with(SLOW_SENSORS);
    bench.ask(130);
    measure(&mut bench, 20, 2_000);
    let outputs = measure(&mut bench, 40, 1_000);
    assert_eq!(bench.guard.telemetry().trust, Trust::Degraded(Reason::Slow));
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (50, Some(Verdict::Doubted(Reason::Slow)))
    );
}

/// Without the filter, nothing limits the robot.
#[test]
fn a_guard_without_its_filter_does_not_slow_the_robot_for_doubts() {
    let mut settings = SLOW_SENSORS.to_vec();
    settings.push((Setting::FilterActive, 0));
    let mut bench = Bench::with(&settings);
    bench.ask(130);
    measure(&mut bench, 20, 2_000);
    let outputs = measure(&mut bench, 40, 1_000);
    assert_eq!(bench.guard.telemetry().trust, Trust::Degraded(Reason::Slow));
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (130, Some(Verdict::Passed))
    );
}

#[test]
fn silent_sensors_of_50_hz_stop_the_robot_within_150_ms() {
    let mut bench = Bench::with(SLOW_SENSORS);
    bench.ask(130);
    measure(&mut bench, 20, 2_000);
    bench.body = None;
    let outputs = bench.run(150);
    assert_eq!(verdict(&outputs), Some(Verdict::Blind(Reason::Silent)));
}

/// At 20 Hz, a rotation of half of 20 rad/s^2 times the square of 49 ms is unseen: 24 mrad. The
/// centre of gravity is 0.13 m to 0.3 m high.
#[test]
fn slower_sensors_leave_narrower_margins() {
    let margins = |hz: i32| {
        let mut bench = Bench::with(&[
            (Setting::InertialRate, hz),
            (Setting::PayloadMass, 4_000),
            (Setting::PayloadUp, 400_000),
        ]);
        measure(&mut bench, 1_000 / hz as u64, 1_000).margins
    };
    let (quick, slow) = (margins(1_000), margins(20));
    let lost = |quick: i16, slow: i16| quick - slow;
    let all = [
        lost(quick.back, slow.back),
        lost(quick.left, slow.left),
        lost(quick.right, slow.right),
    ];
    assert!(all.iter().all(|lost| (3..=8).contains(lost)), "{all:?}");
    assert!(all[0].abs_diff(all[1]) <= 1, "{all:?}");
}
