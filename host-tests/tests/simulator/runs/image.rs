//! Tests of runs in which single nodes are flash images of the motor board. docs/images.md has the
//! ten native runs with which they compare.

use super::{scenario, with};
use std::ops::RangeInclusive;
use tautrack_host_tests::programs::{Board, motor_board};
use tautrack_host_tests::robots::NodeName;
use tautrack_host_tests::simulator::run::Options;

/// Time of the landing in native runs with the seeds 1 to 10, s: mean and three standard
/// deviations.
const LANDING_S: RangeInclusive<f64> = 25.61 - 3.0 * 0.087..=25.61 + 3.0 * 0.087;
/// Minimum margin to the back in the ground truth of these runs, m.
const REAR_MARGIN_M: RangeInclusive<f64> = -0.202..=0.002;
/// Minimum margin in the guard's estimate in these runs, m.
const GUARD_MARGIN_M: RangeInclusive<f64> = 0.157..=0.160;

#[test]
fn a_track_that_is_a_flash_image_climbs_as_native_nodes_do() {
    let program = motor_board().unwrap_or_else(|error| panic!("{error}")).axle;
    let options = Options {
        exchanged: vec![(NodeName::LEFT_TRACK, Board::Image, program)],
        ..Options::default()
    };
    let (summary, _) = with(&scenario("staircase", |_| {}), Board::Native, options);
    assert_eq!(summary.nodes[0].board, "esc1");
    assert!(summary.expectation_met && summary.landed, "{summary}");
    assert!(summary.tension_error_m.unwrap().p99 <= 1.5e-3, "{summary}");
    for (figure, spread) in [
        (summary.landing_time_s, LANDING_S),
        (summary.min_backward_margin_m, REAR_MARGIN_M),
        (summary.min_guard_margin_m, GUARD_MARGIN_M),
    ] {
        let figure = figure.unwrap_or_else(|| panic!("{summary}"));
        assert!(spread.contains(&figure), "{figure}: {spread:?}\n{summary}");
    }
}
