//! Tests which readings of the body sensors are believed.

use tautrack::constants::GRAVITY;
use tautrack::estimate::attitude::Attitude;
use tautrack::sensing::sensor_watch::{SensorState, SensorWatch};
use tautrack::sensing::trust::{Reason, Trust};
use tautrack::sensing::watch::{Expectations, Watch};
use tautrack::sensors::{BodySensors, Fresh, Sensor};

const TICK: f32 = 1e-3;
const STUCK: Trust = Trust::None(Reason::Stuck);

fn expectations(stuck_readings: u32) -> Expectations {
    Expectations {
        stuck_readings,
        rates: [1_000.0, 1_000.0, 1_000.0, 100.0],
    }
}

/// A robot at rest: every reading has the noise of its last digit.
fn resting(step: u32) -> BodySensors {
    let noise = |axis: u32| 1e-4 * ((step * (axis + 3)) % 17) as f32;
    BodySensors {
        inclination: [noise(0), noise(1)],
        specific_force: [noise(2), noise(3), GRAVITY + noise(4)],
        angular_rate: [noise(5), noise(6), noise(7)],
        magnetic_field: [20.0 + noise(8), noise(9), -40.0 + noise(10)],
        fresh: Fresh {
            magnetometer: step.is_multiple_of(10),
            ..Fresh::ALL
        },
    }
}

/// A run of `steps` ms, in which a low-passed `force` is compared with the attitude.
fn run(watch: &mut Watch, steps: u32, force: [f32; 3], change: impl Fn(u32, &mut BodySensors)) {
    let level = Attitude::default();
    for step in 0..steps {
        let mut sensors = resting(step);
        change(step, &mut sensors);
        watch.receive(Some(&sensors), TICK);
        watch.compare(force, &level, true, TICK);
    }
}

const REST: [f32; 3] = [0.0, 0.0, GRAVITY];

/// Within 15 % of 1 g, and within 15 % of the vertical to every side.
#[test]
fn a_force_is_gravity_within_its_bounds_whatever_its_direction() {
    let (doubt, denial) = (Reason::OffGravity, Reason::Disagreement);
    let mut cases = vec![
        ([0.0, 0.0, 0.86], Trust::Full),
        ([0.0, 0.0, 0.84], Trust::None(doubt)),
        ([0.0, 0.0, 1.14], Trust::Full),
        ([0.0, 0.0, 1.16], Trust::None(doubt)),
        ([0.0, 0.0, -1.0], Trust::None(denial)),
    ];
    for turn in 0..8_u16 {
        let (sine, cosine) = (f32::from(turn) * std::f32::consts::FRAC_PI_4).sin_cos();
        for (tangent, trust) in [(0.145, Trust::Full), (0.155, Trust::None(denial))] {
            cases.push(([tangent * cosine, tangent * sine, 1.0], trust));
            // The same direction, ten percent weaker.
            let weaker = [0.9 * tangent * cosine, 0.9 * tangent * sine, 0.9];
            cases.push((weaker, trust));
        }
        cases.push(([0.1 * cosine, 0.1 * sine, 0.85], Trust::Full));
    }
    for (force, trust) in cases {
        let mut watch = Watch::new(&Expectations {
            rates: [100.0; 4],
            ..expectations(0)
        });
        let force = force.map(|share: f32| share * GRAVITY);
        for step in 0..210 {
            watch.receive(Some(&resting(10 * step)), 10.0 * TICK);
            watch.compare(force, &Attitude::default(), true, 10.0 * TICK);
        }
        assert_eq!(watch.trust(), trust, "{force:?}");
    }
}

/// It is forgotten as fast as it came.
#[test]
fn a_contradiction_that_has_ended_is_forgiven() {
    let mut watch = Watch::new(&expectations(0));
    run(&mut watch, 1_500, [0.0, 0.0, 0.5 * GRAVITY], |_, _| ());
    assert_eq!(watch.trust(), Trust::Degraded(Reason::OffGravity));
    run(&mut watch, 700, REST, |_, _| ());
    assert_eq!(watch.trust(), Trust::Degraded(Reason::OffGravity));
    run(&mut watch, 100, REST, |_, _| ());
    assert_eq!(watch.trust(), Trust::Full);
}

#[test]
fn a_magnetometer_that_repeats_while_the_robot_turns_is_stuck_and_nothing_else_is() {
    for stuck in [false, true] {
        let mut watch = Watch::new(&expectations(0));
        run(&mut watch, 500, REST, |_, _| ());
        run(&mut watch, 1_000, REST, |step, sensors| {
            sensors.angular_rate[2] += 0.5;
            let turned = 0.5e-3 * step as f32;
            let [x, y] = [turned.cos(), -turned.sin()].map(|share| 20.0 * share);
            sensors.magnetic_field = if stuck {
                [20.0, 0.0, -40.0]
            } else {
                [x, y, -40.0]
            };
        });
        let magnetometer = if stuck { STUCK } else { Trust::Full };
        assert_eq!(watch.trust_in(Sensor::Magnetometer), magnetometer);
        assert_eq!(watch.trust(), Trust::Full);
    }
}

/// A magnetometer without a new reading does not repeat it.
#[test]
fn a_slow_magnetometer_of_a_turning_robot_is_not_stuck() {
    let mut watch = Watch::new(&expectations(0));
    run(&mut watch, 1_000, REST, |step, sensors| {
        sensors.angular_rate[2] += 3.0;
        sensors.magnetic_field = [20.0, (step / 10) as f32 * 0.1, -40.0];
    });
    assert_eq!(watch.trust_in(Sensor::Magnetometer), Trust::Full);
}

#[test]
fn one_stuck_axis_of_a_gyroscope_is_enough_though_the_robot_rests() {
    for axis in 0..3 {
        let frozen = |_: u32, sensors: &mut BodySensors| sensors.angular_rate[axis] = 0.01;
        let mut watch = Watch::new(&expectations(200));
        run(&mut watch, 190, REST, frozen);
        assert_eq!(watch.trust(), Trust::Full);
        run(&mut watch, 100, REST, frozen);
        assert_eq!(watch.trust(), Trust::Degraded(Reason::Stuck));
        run(&mut watch, 200, REST, frozen);
        assert_eq!(watch.trust(), STUCK);
        assert_eq!(watch.trust_in(Sensor::Accelerometer), Trust::Full);
    }
}

/// An attitude whose inclinometer contradicts it by far more than three degrees, in pitch (0) or in
/// roll (1), upward or downward.
fn contradicted(axis: usize, tilt: f32) -> Attitude {
    let mut attitude = Attitude::default();
    let mut sensors = BodySensors::default();
    for _ in 0..2_000 {
        attitude.update(&sensors, TICK);
    }
    sensors.inclination[axis] = tilt;
    for _ in 0..300 {
        attitude.update(&sensors, TICK);
    }
    let contradiction = attitude.contradiction();
    assert!(contradiction[axis].abs() > 0.1 && contradiction[1 - axis].abs() < 0.01);
    attitude
}

/// Pitch is a rotation about y, roll about x. A gyroscope whose readings change is not accused.
#[test]
fn a_gyroscope_is_accused_if_its_axis_repeats_while_the_inclinometer_turns() {
    for tilt in [-0.3, 0.3] {
        for (axis, about) in [(0, 1), (1, 0)] {
            let attitude = contradicted(axis, tilt);
            for frozen in 0..4 {
                let mut watch = Watch::new(&expectations(0));
                let mut seen = [Trust::Full; 2];
                for step in 0..600 {
                    let mut sensors = resting(step);
                    if let Some(rate) = sensors.angular_rate.get_mut(frozen) {
                        *rate = 0.0;
                    }
                    watch.receive(Some(&sensors), TICK);
                    // The other contradictions count only for a slow robot.
                    watch.compare(REST, &attitude, false, TICK);
                    if step == 300 {
                        seen[0] = watch.trust_in(Sensor::Gyroscope);
                    }
                }
                seen[1] = watch.trust_in(Sensor::Gyroscope);
                let expected = if frozen == about {
                    [Trust::Degraded(Reason::Stuck), STUCK]
                } else {
                    [Trust::Full; 2]
                };
                assert_eq!(seen, expected, "{axis} {tilt} {frozen}");
            }
        }
    }
}

/// The time of a contradiction ends at a second, so that the sensor is believed again three
/// quarters of a second after the end.
#[test]
fn a_gyroscope_that_moves_again_is_forgiven() {
    let attitude = contradicted(1, 0.3);
    let mut watch = Watch::new(&expectations(0));
    for step in 0..5_800 {
        let mut sensors = resting(step);
        if step < 5_000 {
            sensors.angular_rate[0] = 0.0;
        }
        watch.receive(Some(&sensors), TICK);
        watch.compare(REST, &attitude, false, TICK);
        let trust = watch.trust_in(Sensor::Gyroscope);
        match step {
            4_999 | 5_450 => assert_eq!(trust, STUCK, "{step}"),
            5_550 | 5_700 => assert_eq!(trust, Trust::Degraded(Reason::Stuck), "{step}"),
            5_799 => assert_eq!(trust, Trust::Full),
            _ => {}
        }
    }
}

/// One degree of pitch changes gravity along the body by 0.17 m/s^2.
#[test]
fn a_coarse_accelerometer_may_repeat_through_a_rotation_of_a_degree() {
    let mut watch = Watch::new(&expectations(0));
    let mut attitude = Attitude::default();
    let mut sensors = BodySensors {
        specific_force: REST,
        ..BodySensors::default()
    };
    for (steps, pitch) in [(500, 0.0), (5_000, 0.017)] {
        for step in 0..steps {
            sensors.inclination = [pitch + 1e-4 * (step % 3) as f32, 0.0];
            attitude.update(&sensors, TICK);
            watch.receive(Some(&sensors), TICK);
            watch.compare(REST, &attitude, true, TICK);
        }
    }
    assert!(attitude.pitch().radians() > 0.015);
    assert_eq!(watch.trust_in(Sensor::Accelerometer), Trust::Full);
}

/// A bad reading keeps its reason until it is late.
#[test]
fn a_sensor_that_sends_bad_readings_is_not_called_silent() {
    let mut watch = SensorWatch::new(100.0);
    for step in 0..300_u32 {
        let bad = step.is_multiple_of(10).then_some(Err(Reason::NotFinite));
        watch.advance(bad, TICK);
        assert_eq!(watch.trust(), Trust::None(Reason::NotFinite), "{step}");
    }
    for _ in 0..50 {
        watch.advance(None, TICK);
    }
    assert_eq!(watch.trust(), Trust::None(Reason::Silent));
}

#[test]
fn the_rate_of_a_sensor_that_comes_back_is_that_of_its_new_readings() {
    let mut watch = SensorWatch::new(100.0);
    for time in [0, 500] {
        for _ in 0..time {
            watch.advance(None, TICK);
        }
        for step in 0..251_u32 {
            watch.advance(step.is_multiple_of(10).then_some(Ok(())), TICK);
        }
        // A window that begins with a reading has one period less than readings.
        assert!((95.0..101.0).contains(&watch.rate()), "{}", watch.rate());
        assert_eq!(watch.trust(), Trust::Full);
    }
}

#[test]
fn the_age_of_a_lost_sensor_stops_a_second_later() {
    let mut watch = SensorWatch::new(100.0);
    watch.advance(Some(Ok(())), TICK);
    for step in 1..5_000_u16 {
        watch.advance(None, TICK);
        let expected = (f32::from(step) * TICK).min(1.05);
        assert!((watch.age() - expected).abs() < 1e-3, "{step}");
    }
    let state = SensorState::new(&watch, watch.trust());
    assert_eq!((state.health, state.age_ms), (0x21, 1_050));
}

#[test]
fn the_guard_publishes_age_and_rate_of_each_sensor_on_the_body() {
    let mut watch = Watch::new(&expectations(0));
    run(&mut watch, 1_000, REST, |_, _| ());
    for (sensor, rate) in [
        (Sensor::Accelerometer, 1_000.0),
        (Sensor::Magnetometer, 100.0),
    ] {
        let found = watch.sensor(sensor).expect("a sensor on the body");
        assert!(
            (found.rate() - rate).abs() < 0.06 * rate,
            "{}",
            found.rate()
        );
    }
    assert!(watch.sensor(Sensor::GnssReceiver).is_none());
}
