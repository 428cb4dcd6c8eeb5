//! The paper's staircase, and the other shipped scenarios.

use super::{outcome, scenario};
use tautrack_host_tests::nodes::Board;

#[test]
fn five_emulated_nodes_climb_the_staircase_with_the_belt_taut() {
    let (summary, _) = outcome(&scenario("staircase", |_| {}), Board::Qemu);
    assert!(
        summary.landed && !summary.toppled && summary.expectation_met,
        "{summary}"
    );
    assert!(summary.tension_error_m.p99 <= 1.5e-3, "{summary}");
    assert!(summary.tension_error_m.max <= 3.0e-3, "{summary}");
    assert!(
        summary.nodes.iter().all(|node| node.board == "mps2"),
        "{summary}"
    );
}

#[test]
fn the_guard_costs_the_nominal_climb_no_time() {
    let landing = |guard: bool| {
        let (summary, _) = outcome(
            &scenario("staircase", |description| description.guard = guard),
            Board::Native,
        );
        summary
            .landing_time_s
            .unwrap_or_else(|| panic!("{summary}"))
    };
    let (with, without) = (landing(true), landing(false));
    assert!(
        with <= 1.05 * without,
        "{with} s with the guard, {without} s without"
    );
}

#[test]
fn the_short_belt_climbs_too() {
    let (summary, _) = outcome(&scenario("staircase-k080", |_| {}), Board::Native);
    assert!(summary.expectation_met, "{summary}");
    assert!(summary.tension_error_m.max <= 3.0e-3, "{summary}");
}

#[test]
fn level_ground_is_driven_as_asked() {
    let (summary, _) = outcome(&scenario("flat", |_| {}), Board::Native);
    assert!(summary.expectation_met, "{summary}");
}
