//! Tests of how far the guard believes its sensors and its settings.

use super::bench::{Bench, standing, verdict};
use tautrack::node::guard::State;
use tautrack::sensors::BodySensors;
use tautrack::settings::Setting;
use tautrack::stability::filter::Verdict;
use tautrack::stability::parameters::Refusal;
use tautrack::stability::support::Edge;
use tautrack::stability::trip::Cause;
use tautrack::stability::trust::{Reason, Trust};

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
