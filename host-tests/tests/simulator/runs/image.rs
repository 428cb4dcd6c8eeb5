//! Tests of runs in which single nodes are flash images of their board. The run of a track compares
//! with ten runs of host nodes: `cargo demo --nodes host --seed N`, with N from 1 to 10.

use super::{outcome, programs, scenario, with};
use crate::unchanged;
use std::ops::RangeInclusive;
use tautrack_host_tests::programs::{Board, Program, guard_board, motor_board};
use tautrack_host_tests::results::summary::Summary;
use tautrack_host_tests::robots::{Kind, NodeName};
use tautrack_host_tests::scenario::Expect;
use tautrack_host_tests::simulator::record::Sample;
use tautrack_host_tests::simulator::run::Options;
use tautrack_host_tests::world::terrain::Terrain;

/// Time of the landing in runs with the seeds 1 to 10, s: mean and three standard
/// deviations.
const LANDING_S: RangeInclusive<f64> = 25.55 - 3.0 * 0.109..=25.55 + 3.0 * 0.109;
/// Minimum margin to the back in the ground truth of these runs, m.
const REAR_MARGIN_M: RangeInclusive<f64> = -0.202..=0.002;
/// Minimum margin in the guard's estimate in these runs, m.
const GUARD_MARGIN_M: RangeInclusive<f64> = 0.157..=0.160;

/// Runs a test, unless it has passed with the same flash image and the same nodes.
fn unless_unchanged(name: &str, image: &Program, test: impl FnOnce()) {
    let host = unchanged::nodes(programs(Board::Host));
    let image = unchanged::digests([image]);
    unchanged::unless_unchanged(name, host.into_iter().chain(image), test);
}

#[test]
#[ignore = "executes a flash image for minutes; docs/testing.md has the complete campaigns"]
fn a_track_that_is_a_flash_image_climbs_as_nodes_of_the_host_do() {
    let program = motor_board().unwrap_or_else(|error| panic!("{error}")).axle;
    unless_unchanged("image-of-a-track", &program.clone(), || {
        let options = Options {
            exchanged: vec![(NodeName::LEFT_TRACK, Board::Image, program)],
            ..Options::default()
        };
        let (summary, _) = with(&scenario("staircase", |_| {}), Board::Host, options);
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
    });
}

/// The guard homes the drives, arms, and drives onto the stairs. So every sensor chip has to show a
/// motion, over the model of the I2C bus.
#[test]
fn a_guard_that_is_a_flash_image_arms_and_drives_as_one_of_the_host_does() {
    let name = Kind::B2p2.facts().guard_program;
    let programs = guard_board(&[name]).unwrap_or_else(|error| panic!("{error}"));
    let program = programs.into_iter().next().expect("one program");
    unless_unchanged("image-of-the-guard", &program.clone(), || {
        let short = scenario("staircase", |description| {
            description.duration_s = 7.5;
            description.expect = Expect::default();
            description.operator.events.truncate(1);
            if let Terrain::Stairs { first_nose_m, .. } = &mut description.terrain {
                *first_nose_m = 0.85;
            }
        });
        let host = outcome(&short, Board::Host);
        let options = Options {
            exchanged: vec![(NodeName::GUARD, Board::Image, program)],
            ..Options::default()
        };
        let image = with(&short, Board::Host, options);
        let boards = [&host, &image].map(|(summary, _)| {
            let mut nodes = summary.nodes.iter();
            nodes
                .find(|node| node.role == "guard")
                .map(|node| &*node.board)
        });
        assert_eq!(boards, [Some("host"), Some("g474")]);
        for run in [&host, &image] {
            climbs(run);
        }
        let [host, image] = [host, image].map(|(summary, _)| summary.driven_m);
        assert!((image - host).abs() < 0.02, "{image} {host}");
    });
}

/// Asserts that the robot is armed at the end, was never held back, has climbed, and that the guard
/// knew its pitch.
fn climbs((summary, samples): &(Summary, Vec<Sample>)) {
    assert_eq!(summary.guard.interventions, 0, "{summary}");
    let end = samples.last().expect("samples");
    assert_eq!(end.received.guard_state, "armed", "{summary}");
    let armed = samples
        .iter()
        .filter(|sample| sample.received.guard_state == "armed");
    let worst =
        |error: fn(&Sample) -> f64| armed.clone().map(error).fold(0.0, f64::max).to_degrees();
    let pitch = worst(|sample| sample.truth.pitch);
    let errors = [
        worst(|sample| (sample.received.pitch - sample.truth.pitch).abs()),
        worst(|sample| (sample.received.roll - sample.truth.roll).abs()),
    ];
    println!(
        "pitch up to {pitch:.1} degrees, errors {errors:.2?}, driven {:.3} m",
        summary.driven_m
    );
    assert!(pitch > 15.0, "{pitch}\n{summary}");
    assert!(errors[0] < 2.0 && errors[1] < 1.0, "{errors:?}\n{summary}");
}
