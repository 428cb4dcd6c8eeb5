//! Tests of how far the guard believes its sensors and its settings.

use super::bench::{Bench, standing, verdict};
use tautrack::bus::pdo::Request;
use tautrack::node::guard::State;
use tautrack::sensing::trust::{Reason, Trust};
use tautrack::sensors::{BodySensors, Fresh, Sensor};
use tautrack::settings::{Setting, Settings};
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

/// A sensor with a fault that one reading shows, and how it is named.
type Fault = (fn(&mut BodySensors), Sensor, Reason);

/// An accelerometer whose registers read zero, sensors on a board that is upside down, and a robot
/// that falls. Its trip by the sensors follows 100 ms later.
#[test]
fn zeros_a_sensor_upside_down_and_free_fall_are_named_within_100_ms() {
    let faults: [Fault; 4] = [
        (
            |body| body.specific_force = [0.0; 3],
            Sensor::Accelerometer,
            Reason::Zero,
        ),
        (
            |body| body.specific_force[2] = -9.81,
            Sensor::Accelerometer,
            Reason::UpsideDown,
        ),
        (
            |body| body.inclination = [3.1, 0.0],
            Sensor::Inclinometer,
            Reason::UpsideDown,
        ),
        (
            |body| body.specific_force = [0.4, -0.3, 1.0],
            Sensor::Accelerometer,
            Reason::FreeFall,
        ),
    ];
    for (fault, sensor, reason) in faults {
        let mut bench = Bench::armed();
        bench.ask(130);
        bench.run(1_000);
        let mut body = standing(0.0);
        fault(&mut body);
        // The digits of an accelerometer without supply do not change.
        bench.exact = reason == Reason::Zero;
        bench.body = Some(body);
        let outputs = bench.run(100);
        assert_eq!(verdict(&outputs), Some(Verdict::Blind(reason)));
        assert_eq!(
            bench.guard.sensor(sensor).health,
            Trust::None(reason).code()
        );
        let outputs = bench.run(150);
        assert_eq!(outputs.passed.passed_speed, 0);
        let snapshot = bench.guard.telemetry().snapshot;
        assert_eq!(
            snapshot.map(|kept| kept.cause),
            Some(Cause::Sensors(reason))
        );
    }
}

/// A fall of 20 cm lasts 202 ms, one of 5 cm 101 ms, one of 1 cm 45 ms. After a short one the robot
/// drives on; it trips 160 ms after the beginning of a long one.
#[test]
fn a_robot_that_is_dropped_stops_and_trips_if_it_falls_deep() {
    for (fall_ms, named, trips) in [(45, false, false), (101, true, false), (202, true, true)] {
        let mut bench = Bench::armed();
        bench.ask(130);
        bench.run(1_500);
        bench.body = Some(BodySensors {
            specific_force: [0.1, 0.0, 0.1],
            ..standing(0.0)
        });
        let mut falls = false;
        for _ in 0..fall_ms {
            falls |= verdict(&bench.tick()) == Some(Verdict::Blind(Reason::FreeFall));
        }
        assert_eq!(falls, named, "{fall_ms} ms");
        // The impact.
        bench.body = Some(BodySensors {
            specific_force: [0.0, 0.0, 50.0],
            ..standing(0.0)
        });
        bench.run(20);
        bench.body = Some(standing(0.0));
        let outputs = bench.run(1_000);
        assert_eq!(outputs.passed.passed_speed == 0, trips, "{fall_ms} ms");
        assert_eq!(bench.guard.telemetry().tripped, trips, "{fall_ms} ms");
    }
}

/// Readings of a robot at rest whose gyroscope has this constant error about y, degrees/s.
fn biased(degrees: f32) -> BodySensors {
    BodySensors {
        angular_rate: [0.0, degrees.to_radians(), 0.0],
        ..standing(0.0)
    }
}

fn powered_up(degrees: f32) -> Bench {
    let mut bench = Bench::new(&Settings::default());
    bench.body = Some(biased(degrees));
    bench.run(200);
    bench.request(Request::Arm);
    bench.run(1_800);
    bench
}

#[test]
fn a_gyroscope_with_a_constant_error_of_4_degrees_per_second_does_not_turn_the_pitch() {
    for degrees in [-4.0, 4.0] {
        let mut bench = powered_up(degrees);
        let outputs = bench.run(4);
        assert_eq!(State::from_code(outputs.state.state), Some(State::Armed));
        bench.ask(130);
        bench.velocities = [1_000_000; 2];
        let outputs = bench.run(8_000);
        assert_eq!(verdict(&outputs), Some(Verdict::Passed));
        let pitch = outputs.motion.pitch;
        assert!(pitch.abs() <= 10, "{degrees}: {pitch} of 0.01 degree");
    }
}

/// A track that says nothing may turn the robot.
#[test]
fn nothing_is_learned_while_a_track_is_silent() {
    for (silent, wrong) in [(None, false), (Some(2), true)] {
        let mut bench = Bench::new(&Settings::default());
        bench.silent = silent;
        bench.body = Some(biased(4.0));
        let pitch = bench.run(8_000).motion.pitch;
        assert_eq!(
            pitch.abs() > 300,
            wrong,
            "{silent:?}: {pitch} of 0.01 degree"
        );
    }
}

#[test]
fn a_gyroscope_that_reads_too_much_at_rest_is_not_armed_and_the_refusal_has_the_value() {
    for (degrees, armed) in [(5.9, true), (-5.9, true), (6.2, false), (-6.2, false)] {
        let mut bench = powered_up(degrees);
        let state = State::from_code(bench.run(4).state.state);
        assert_eq!(state == Some(State::Armed), armed, "{degrees}");
        let refusal = bench.guard.telemetry().refusal;
        match refusal {
            None => assert!(armed),
            Some(Refusal::RateAtRest { rate, bound }) => {
                assert!((rate.to_degrees() - degrees.abs()).abs() < 0.01 && bound < rate);
            }
            Some(_) => panic!("{refusal:?}"),
        }
    }
}

/// B2P2's centre of gravity is some 0.1 m above its edges, and 12 degrees take 20 mm.
#[test]
fn a_robot_that_is_carried_is_armed_with_narrow_margins_until_it_stands() {
    let mut bench = Bench::new(&Settings::default());
    let carry = |bench: &mut Bench, ticks: u32| {
        for _ in 0..ticks {
            let time = bench.now_us as f32 * 1e-6;
            bench.body = Some(BodySensors {
                angular_rate: [0.0, -0.1 * time.cos(), 0.0],
                ..standing(0.1 * time.sin())
            });
            bench.tick();
        }
    };
    carry(&mut bench, 200);
    bench.request(Request::Arm);
    carry(&mut bench, 4_000);
    let outputs = bench.guard.outputs().clone();
    assert_eq!(State::from_code(outputs.state.state), Some(State::Armed));
    assert_eq!(bench.guard.telemetry().refusal, None);
    // The last moments of the motion, at its top.
    bench.body = Some(standing(0.0));
    let carried = bench.run(100).margins;
    let stands = bench.run(3_000);
    let lost = stands.margins.left - carried.left;
    assert!((10..=60).contains(&lost), "{lost}");
    assert!(!bench.guard.telemetry().tripped);
}

/// B2P2's centre of gravity is some 0.1 m above its edges: a residual of 0.1 degree/s a minute,
/// over a time constant of 2 s, takes 0.35 mm a minute from every margin.
#[test]
fn margins_narrow_with_the_time_since_the_robot_rested() {
    let mut bench = Bench::with(&[(Setting::PayloadMass, 4_000), (Setting::PayloadUp, 400_000)]);
    let before = bench.run(100).margins;
    bench.velocities = [1_000_000; 2];
    let after = bench.run(300_000).margins;
    let lost = [before.back - after.back, before.left - after.left];
    assert!(lost.iter().all(|lost| (3..=8).contains(lost)), "{lost:?}");
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
