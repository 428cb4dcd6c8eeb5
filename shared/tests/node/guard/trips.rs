//! Tests of the guard's latch: trips, emergency stops, and the ways out of them.

use super::bench::{Bench, verdict};
use tautrack::bus::pdo::Request;
use tautrack::settings::Setting;
use tautrack::stability::bands::Band;
use tautrack::stability::filter::Verdict;
use tautrack::stability::support::Edge;
use tautrack::stability::trip::Cause;

/// Pitch, rad, at which the robot stands on its rear pulleys, with its centre of gravity 5 mm in
/// front of them.
const TRIPPING: f32 = 1.551;

#[test]
fn a_trip_latches_and_the_override_leaves_it_at_crawl_speed() {
    let mut bench = Bench::armed();
    bench.ask(130);
    bench.tilt(TRIPPING);
    let outputs = bench.run(200);
    assert_eq!(verdict(&outputs), Some(Verdict::Tripped(Edge::Back)));
    let known = bench.guard.telemetry();
    assert_eq!((known.band, known.trips), (Band::Stop, 1));
    let kept = known.snapshot.expect("a snapshot");
    assert_eq!(kept.cause, Cause::Margin(Edge::Back));
    assert!(
        (kept.command.forward - 0.13).abs() < 1e-6 && kept.margins[0] < 0.01,
        "{kept:?}"
    );

    // Nothing passes, not even backward. A reset has no effect while the margin is too narrow.
    bench.ask(-130);
    assert_eq!(bench.run(500).passed.passed_speed, 0);
    bench.request(Request::Reset);
    bench.run(100);
    bench.request(Request::Arm);
    assert_eq!(bench.run(500).passed.passed_speed, 0);
    bench.request(Request::Override);
    let outputs = bench.run(500);
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (-50, Some(Verdict::Overridden(Edge::Back)))
    );
    bench.tilt(0.3);
    bench.request(Request::Arm);
    assert_eq!(bench.run(500).passed.passed_speed, 0, "still tripped");
    bench.request(Request::Reset);
    bench.run(100);
    bench.request(Request::Arm);
    assert_eq!(bench.run(1_000).passed.passed_speed, -130);
}

#[test]
fn backing_off_goes_back_at_crawl_speed_where_a_setting_allows_it() {
    for (allowed, expected) in [(0, 0), (1, -50)] {
        let mut bench = Bench::with(&[(Setting::BackOff, allowed)]);
        bench.ask(130);
        bench.tilt(TRIPPING);
        assert_eq!(bench.run(500).passed.passed_speed, 0, "not requested");
        bench.request(Request::BackOff);
        assert_eq!(bench.run(500).passed.passed_speed, expected);
        bench.command = None;
        assert_eq!(bench.run(800).passed.passed_speed, 0, "held to run");
    }
}

#[test]
fn an_emergency_stop_by_anybody_stops_and_latches() {
    let mut bench = Bench::armed();
    bench.ask(130);
    bench.run(1_000);
    bench.emergency_stop = true;
    let outputs = bench.run(500);
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (0, Some(Verdict::EmergencyStopped))
    );
    bench.emergency_stop = false;
    assert_eq!(
        bench.run(500).passed.passed_speed,
        0,
        "released, not cleared"
    );
    bench.request(Request::Reset);
    bench.run(10);
    bench.request(Request::Arm);
    assert_eq!(bench.run(1_000).passed.passed_speed, 130);
}

#[test]
fn an_override_is_for_margins_only() {
    for (cause, moves) in [("margin", true), ("emergency stop", false)] {
        let mut bench = Bench::armed();
        bench.ask(130);
        bench.tilt(TRIPPING);
        bench.emergency_stop = cause == "emergency stop";
        bench.run(100);
        bench.emergency_stop = false;
        bench.ask(-130);
        bench.request(Request::Override);
        let speed = bench.run(1_000).passed.passed_speed;
        assert_eq!(speed != 0, moves, "{cause}: {speed} mm/s");
    }
}

/// A robot on its back may have to be driven without the sensors that it has lost.
#[test]
fn an_override_needs_no_sensors() {
    let mut bench = Bench::armed();
    bench.ask(130);
    bench.tilt(TRIPPING);
    bench.body = None;
    bench.ask(-130);
    bench.request(Request::Override);
    let outputs = bench.run(1_000);
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (-50, Some(Verdict::Overridden(Edge::Back)))
    );
}

/// `chassis_speed` is 0.5 rad/s, which is 20.9 units of 2^-16 turn in 4 ms.
#[test]
fn in_an_override_the_chassis_turns_at_a_quarter_of_its_speed() {
    let mut bench = Bench::armed();
    bench.ask(130);
    bench.tilt(TRIPPING);
    bench.ask(0);
    bench.command.as_mut().expect("an operator").posture = 3_000;
    bench.request(Request::Override);
    bench.run(200);
    let before = bench.tick().passed.passed_posture;
    let turned = bench.run(400).passed.passed_posture - before;
    let expected = 100.0 * 20.9 / 4.0;
    assert!((f64::from(turned) - expected).abs() < 10.0, "{turned}");
}
