//! Tests the guard with operators who command too much on a nose.

use super::{outcome, scenario, unless_unchanged};
use tautrack_host_tests::programs::Board;

#[test]
fn front_kept_up_topples_without_the_guard() {
    unless_unchanged("front-kept-up-topples", || {
        let without = scenario("staircase-front-kept-up", |description| {
            description.guard = false;
            description.expect.guard_intervenes = None;
        });
        let (summary, _) = outcome(&without, Board::Host);
        assert!(summary.toppled, "{summary}");
    });
}

#[test]
fn front_kept_up_is_held_back_and_no_earlier_than_its_margin_asks_for() {
    unless_unchanged("front-kept-up-held", || {
        let (summary, samples) = outcome(&scenario("staircase-front-kept-up", |_| {}), Board::Host);
        assert!(!summary.toppled && summary.expectation_met, "{summary}");

        let armed = |index: &usize| samples[*index].received.guard_state == "armed";
        let first = (0..samples.len()).filter(armed).find(|index| {
            let received = &samples[*index].received;
            received.asked_speed > 0.0 && received.verdict != "passed"
        });
        let first = first.expect("the guard acts");
        // Until then, the robot drives as fast as commanded, except for the ramp after arming.
        let start = (0..first).find(|index| {
            samples[*index].received.passed_speed >= samples[*index].received.asked_speed
                && samples[*index].received.asked_speed > 0.0
        });
        for sample in &samples[start.expect("full speed is reached")..first] {
            let (asked, passed) = (sample.received.asked_speed, sample.received.passed_speed);
            assert!(
                passed >= asked - 1e-3,
                "{passed} of {asked} m/s at {} s",
                sample.time_s
            );
        }
        // The margin is then that of the caution band plus what is lost within the horizon.
        let back = samples[first]
            .received
            .margins
            .expect("margins are on the bus")[0];
        assert!(back < 0.15, "the guard acts at {back} m");
        let pitch = samples[first].truth.pitch.to_degrees();
        assert!(pitch > 44.0, "the guard acts at {pitch} degrees");
    });
}

/// The guard must count both the rear pulley in the air and the lift of the fold. With a guard that
/// counts neither, this robot topples at 15.7 s.
#[test]
fn a_robot_on_one_rear_pulley_neither_drives_nor_folds_itself_over_its_diagonal() {
    let (summary, samples) = outcome(&scenario("curb-turned-and-folded", |_| {}), Board::Host);
    assert!(!summary.toppled && summary.expectation_met, "{summary}");
    let steepest = samples.iter().map(|sample| sample.truth.pitch);
    let steepest = steepest.fold(0.0, f64::max).to_degrees();
    assert!(steepest < 58.0, "{steepest} degrees");
}
