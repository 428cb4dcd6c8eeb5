//! Whole runs of the other robots: node programs, bus, plant and operator together; one file per robot.

mod crawler;
mod hylos;
mod rt_mover;

use std::path::Path;
use tautrack_host_tests::programs::{Board, Programs};
use tautrack_host_tests::results::summary::Summary;
use tautrack_host_tests::robots::Kind;
use tautrack_host_tests::scenario::{Description, Event, Expect, Scenario};
use tautrack_host_tests::simulator::record::Sample;
use tautrack_host_tests::simulator::run::{Options, run};

/// The programs of `kind` for `board`; quick when they are built.
fn programs(board: Board, kind: Kind) -> Programs {
    kind.programs(board)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// A shipped scenario, changed.
fn scenario(name: &str, change: impl FnOnce(&mut Description)) -> Scenario {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenarios")
        .join(name)
        .with_extension("toml");
    let mut description = Scenario::load(&path)
        .unwrap_or_else(|error| panic!("{error}"))
        .description();
    change(&mut description);
    Scenario::checked(description).unwrap_or_else(|error| panic!("{error}"))
}

/// Runs `scenario` on `board` and prints what came out.
fn outcome(scenario: &Scenario, board: Board) -> (Summary, Vec<Sample>) {
    let options = Options {
        end_when_toppled: true,
        ..Options::default()
    };
    let programs = programs(board, scenario.kind());
    let outcome =
        run(scenario, &programs, options, &mut |_| {}).unwrap_or_else(|error| panic!("{error}"));
    let summary = Summary::new(scenario, &outcome.facts, &outcome.samples);
    println!("{summary}");
    (summary, outcome.samples)
}

/// Virtual time that emulated nodes are compared over: homing, arming, and each robot at its work, s.
const COMPARED_S: f64 = 25.0;

/// The beginning of a shipped scenario: emulated cores and programs of this computer agree in every
/// bit of the plant and of the frames.
fn ends_in_the_same_bits(name: &str) {
    let beginning = scenario(name, |description| {
        description.duration_s = COMPARED_S;
        description.expect = Expect::default();
        let events = &mut description.operator.events;
        let late = |event: &Event| event.when.after_s.is_some_and(|after| after > COMPARED_S);
        events.truncate(events.iter().position(late).unwrap_or(events.len()));
    });
    let [native, emulated] = [Board::Native, Board::Qemu].map(|board| outcome(&beginning, board).0);
    assert_eq!(native.state_hash, emulated.state_hash, "{name}");
}
