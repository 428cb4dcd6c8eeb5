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
        (kept.asked.forward - 0.13).abs() < 1e-6 && kept.margins[0] < 0.01,
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
    assert_eq!(outputs.passed.passed_speed, 0);
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
