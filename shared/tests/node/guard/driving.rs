//! Tests of how much of the operator's speed passes.

use super::bench::{Bench, verdict};
use tautrack::bus::pdo::{DEAD_MAN_HELD, Request};
use tautrack::node::guard::State;
use tautrack::settings::Setting;
use tautrack::stability::filter::Verdict;
use tautrack::stability::support::Edge;

#[test]
fn level_ground_passes_the_command_to_both_tracks() {
    let mut bench = Bench::armed();
    bench.ask(130);
    let outputs = bench.run(1_000);
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (130, Some(Verdict::Passed))
    );
    // 0.13 m/s on a pulley with a radius of 0.05 m.
    for speed in bench.track_speeds() {
        assert!((speed - 2_600_000).abs() < 2_000, "{speed}");
    }
}

#[test]
fn a_margin_below_the_stop_margin_refuses_forward_and_lets_the_robot_back_out_slowly() {
    let mut bench = Bench::armed();
    // At this pitch the centre of gravity, 0.258 m in front of axle 1 along the body, is only 23 mm
    // in front of it.
    bench.tilt(1.48);
    bench.ask(130);
    let outputs = bench.run(1_000);
    assert_eq!(verdict(&outputs), Some(Verdict::Refused(Edge::Back)));
    assert_eq!(outputs.passed.passed_speed, 0);
    assert!(
        (15..35).contains(&outputs.margins.back),
        "{:?}",
        outputs.margins
    );
    // 13 of the 40 mm between trip margin and stop margin are left.
    bench.ask(-50);
    let outputs = bench.run(1_000);
    let expected = -16 - 2..=-16 + 2;
    assert!(
        expected.contains(&outputs.passed.passed_speed),
        "{outputs:?}"
    );
}

#[test]
fn an_operator_who_falls_silent_stops_the_robot() {
    let mut bench = Bench::armed();
    bench.ask(130);
    bench.run(1_000);
    bench.command = None;
    let outputs = bench.run(800);
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (0, Some(Verdict::Unattended))
    );
}

#[test]
fn nothing_passes_unless_the_operator_requests_to_drive() {
    let mut bench = Bench::armed();
    bench.ask(130);
    assert_eq!(bench.run(1_000).passed.passed_speed, 130);
    bench.request(Request::Stop);
    assert_eq!(bench.run(1_000).passed.passed_speed, 0);
    bench.request(Request::Arm);
    assert_eq!(bench.run(1_000).passed.passed_speed, 130);
}

#[test]
fn the_stop_keeps_to_the_deceleration_in_the_settings() {
    let mut bench = Bench::armed();
    bench.ask(200);
    bench.run(1_000);
    bench.ask(0);
    let mut before = bench.tick().passed.passed_speed;
    while before > 0 {
        let now = bench.run(4).passed.passed_speed;
        // 0.4 m/s^2 over 4 ms, in whole mm/s.
        assert!(before - now <= 3, "{before} to {now} mm/s");
        before = now;
    }
}

#[test]
fn a_command_beyond_the_speed_limit_is_the_limit() {
    let mut bench = Bench::armed();
    bench.ask(i16::MAX);
    let outputs = bench.run(3_000);
    // The yaw rate that holds the heading takes a little of the speed. Each belt stays within the
    // limit.
    let passed = outputs.passed.passed_speed;
    assert!((420..=450).contains(&passed), "{outputs:?}");
    for speed in bench.track_speeds() {
        // 0.45 m/s on a pulley with a radius of 0.05 m.
        assert!(speed <= 9_000_000, "{speed}");
    }
}

#[test]
fn nothing_passes_unless_the_dead_man_switch_is_held() {
    let mut bench = Bench::with(&[(Setting::DeadMan, 1)]);
    let outputs = bench.run(1_000);
    assert_eq!(State::from_code(outputs.state.state), Some(State::Ready));
    bench.command.as_mut().expect("an operator").request |= DEAD_MAN_HELD;
    bench.ask(130);
    assert_eq!(bench.run(2_000).passed.passed_speed, 130);
    bench.request(Request::Arm);
    let outputs = bench.run(1_000);
    assert_eq!(
        (outputs.passed.passed_speed, verdict(&outputs)),
        (0, Some(Verdict::Unattended))
    );
}
