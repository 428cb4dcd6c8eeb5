//! Tests of the climb of the paper's staircase; `snapshot` tests the other shipped scenarios.

use super::{climb, outcome, scenario, unless_unchanged};
use tautrack_host_tests::programs::Board;

#[test]
fn five_nodes_climb_the_staircase_with_the_belt_taut() {
    unless_unchanged("climb", || {
        let (summary, _) = climb(Board::Host);
        assert!(
            summary.landed && !summary.toppled && summary.expectation_met,
            "{summary}"
        );
        assert!(summary.tension_error_m.unwrap().p99 <= 1.5e-3, "{summary}");
        assert!(summary.tension_error_m.unwrap().max <= 3.0e-3, "{summary}");
    });
}

#[test]
fn the_guard_costs_the_nominal_climb_no_time() {
    unless_unchanged("climb-without-guard", || {
        let (without, _) = outcome(
            &scenario("staircase", |description| description.guard = false),
            Board::Host,
        );
        let landing = |summary: &tautrack_host_tests::results::summary::Summary| {
            summary
                .landing_time_s
                .unwrap_or_else(|| panic!("{summary}"))
        };
        let (with, without) = (landing(&climb(Board::Host).0), landing(&without));
        assert!(
            with <= 1.05 * without,
            "{with} s with the guard, {without} s without"
        );
    });
}
