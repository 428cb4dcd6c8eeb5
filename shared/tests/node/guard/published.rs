//! Tests what the guard publishes of the robot, and the feed-forward that it sends.

use super::bench::{Bench, JOINT, SCREW, standing};
use tautrack::bus::network::{Emergency, emergency};
use tautrack::bus::pdo::{Payload, Request, TorqueOffset, receive};
use tautrack::estimate::attitude::Attitude;
use tautrack::estimate::state::Validity;
use tautrack::faults::Fault;
use tautrack::math::Turns;
use tautrack::motor::profile::Motion;
use tautrack::node::guard::commissioning::{Reason, progress, request};
use tautrack::robots::b2p2::FrontPart;
use tautrack::screw::Geometry;
use tautrack::sensors::{BodySensors, Sensor};
use tautrack::settings::{Setting, Settings};
use tautrack::units::Angle;

/// A guard whose sensors have read this since its start, half a second ago.
fn started(body: BodySensors) -> Bench {
    let mut bench = Bench::new(&Settings::default());
    bench.body = Some(body);
    bench.run(500);
    bench
}

/// Pitch and roll in 0.01 degree, heading in 2^-16 turn.
#[test]
fn the_attitude_is_published_in_its_units() {
    let (pitch, roll) = (0.2_f32, -0.1_f32);
    let bench = started(BodySensors {
        inclination: [pitch, roll],
        specific_force: [
            9.81 * pitch.sin() * roll.cos(),
            9.81 * roll.sin(),
            9.81 * pitch.cos() * roll.cos(),
        ],
        ..standing(0.0)
    });
    let motion = bench.guard.outputs().motion;
    assert!(motion.pitch.abs_diff(1_146) <= 1, "{motion:?}");
    assert!(motion.roll.abs_diff(-573) <= 1, "{motion:?}");
    for heading in [-2.0, 0.5, 3.0_f32] {
        let bench = started(BodySensors {
            magnetic_field: [20.0 * heading.cos(), -20.0 * heading.sin(), -40.0],
            ..standing(0.0)
        });
        let expected = (heading / std::f32::consts::TAU * 65_536.0) as i16;
        let found = bench.guard.outputs().state.heading;
        // The compass errs by up to 0.163 degree, 30 units.
        assert!(found.abs_diff(expected) <= 32, "{found} {expected}");
    }
}

#[test]
fn the_state_of_the_robot_has_its_attitude_and_the_validity_of_its_position() {
    let mut bench = started(BodySensors {
        magnetic_field: [20.0, 0.0, -40.0],
        ..standing(0.15)
    });
    let (state, position) = (0..4)
        .find_map(|_| bench.tick().robot)
        .expect("once in a SYNC period");
    assert!((state[5].value - 0.15).abs() < 1e-3, "{:?}", state[5]);
    assert_eq!(state[5].validity, Validity::Measured);
    // No position; a heading whose magnetometer repeats is carried on or measured.
    assert_eq!(position.validity & 0x3f, 0);
    assert_ne!(position.validity >> 6, 0);
    assert_eq!(position.age, 255);
}

#[test]
fn a_command_that_passes_whole_has_a_scale_of_100_percent() {
    let mut bench = Bench::armed();
    bench.ask(100);
    assert_eq!(bench.run(800).state.scale, 100);
}

#[test]
fn the_rates_and_the_health_of_the_sensors_are_published() {
    let mut bench = Bench::new(&Settings::default());
    bench.run(1_000);
    for sensor in [Sensor::Inclinometer, Sensor::Gyroscope] {
        let state = bench.guard.sensor(sensor);
        assert!(state.rate.abs_diff(10_000) < 500, "{state:?}");
        assert_eq!(state.health, 0);
    }
    // There is no GNSS receiver.
    let state = bench.guard.sensor(Sensor::GnssReceiver);
    assert_eq!((state.rate, state.health), (0, 0x21));
}

/// Straight and level, the front part presses on the joint with its weight, and not on the screw.
#[test]
fn an_armed_guard_sends_the_load_of_the_front_part() {
    let geometry = Geometry::from_micrometres(320_000, 230_000, 1_232_000).expect("a geometry");
    let mut attitude = Attitude::default();
    attitude.update(&standing(0.0), 1e-3);
    let rest = Motion {
        position: Turns::ZERO,
        velocity: 0.0,
        acceleration: 0.0,
    };
    let straight = geometry.extension(Angle::ZERO);
    let front = FrontPart::new(&geometry, &Settings::default());
    let load = front.load(straight, 0.0, &rest, &attitude);
    let mut bench = Bench::armed();
    bench.run(200);
    let mut sent = [None; 2];
    for _ in 0..40 {
        let frames = bench.tick().frames;
        for (sent, node) in sent.iter_mut().zip([JOINT, SCREW]) {
            let found = frames
                .iter()
                .find_map(|frame| TorqueOffset::from_frame(frame, receive(3), node));
            *sent = found.or(*sent);
        }
    }
    let [joint, screw] = sent.map(|sent| f32::from(sent.expect("a feed-forward").torque));
    // In 0.01 N m and N.
    assert!(
        load.joint > 1.0 && (joint - 100.0 * load.joint).abs() <= 2.0,
        "{joint} {load:?}"
    );
    assert!((screw - load.screw).abs() <= 1.0, "{screw} {load:?}");
}

/// Requests of the operator are in mrad/s, seen from above.
#[test]
fn a_yaw_rate_turns_the_tracks_against_each_other() {
    let mut bench = Bench::armed();
    bench.command.as_mut().expect("an operator").yaw_rate = 100;
    bench.run(1_500);
    let [left, right] = bench.track_speeds()[..] else {
        panic!("no set-points")
    };
    let gauge = Settings::default().si(Setting::TrackGauge);
    // 0.1 rad/s, half of the gauge, a pulley of 0.05 m, in 1e-6 rad/s.
    let expected = 0.1 * 0.5 * gauge / 0.05 * 1e6;
    assert!(
        (right as f32 - expected).abs() < 0.02 * expected,
        "{right} {expected}"
    );
    assert!(
        (left as f32 + expected).abs() < 0.02 * expected,
        "{left} {expected}"
    );
}

#[test]
fn sensors_are_commissioned_at_rest_in_a_guard_that_is_not_armed() {
    let mut bench = Bench::new(&Settings::default());
    bench.run(100);
    bench.guard.commission(request::LEVEL);
    assert_eq!(bench.guard.commissioning().progress, request::LEVEL);
    let mut bench = Bench::armed();
    bench.guard.commission(request::LEVEL);
    let report = bench.guard.commissioning();
    assert_eq!(report.progress, progress::REFUSED);
    assert_eq!(report.reason, Reason::NotDisarmed as u8);
}

/// The fault comes at each phase of the SYNC period.
#[test]
fn a_fault_and_its_end_are_reported_once_each_with_the_faulty_drives() {
    for phase in 0..4 {
        let mut bench = Bench::armed();
        bench.run(20 + phase);
        let code = Fault::Blocked.code();
        bench.extra.push(emergency(Emergency { node: 3, code }));
        let mut reports = Vec::new();
        for tick in 0..200 {
            if tick == 100 {
                bench.request(Request::Reset);
            }
            let outputs = bench.tick();
            let report = outputs.emergency.map(|code| (code, outputs.faulty_drives));
            reports.extend(report);
        }
        assert_eq!(reports, [(code, 0b10), (0, 0)], "phase {phase}");
    }
}

/// A drive with a fault is one of several: the guard reports only the first fault.
#[test]
fn the_faulty_drives_are_updated_once_in_a_sync_period() {
    let mut bench = Bench::armed();
    for (drives, node) in [(0b10, 3), (0b110, 4)] {
        let code = Fault::Blocked.code();
        bench.extra.push(emergency(Emergency { node, code }));
        assert_eq!(bench.run(4).faulty_drives, drives);
    }
}
