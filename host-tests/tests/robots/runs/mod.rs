//! Tests of whole runs, one file per robot other than B2P2: nodes, bus, plant and operator.

mod crawler;
mod hylos;
mod rt_mover;

use crate::unchanged;
use std::path::Path;
use tautrack_host_tests::programs::{Board, Programs};
use tautrack_host_tests::results::summary::Summary;
use tautrack_host_tests::robots::Kind;
use tautrack_host_tests::scenario::{Description, Event, Expect, Scenario};
use tautrack_host_tests::simulator::record::Sample;
use tautrack_host_tests::simulator::run::{Options, run};

/// Returns the programs of `kind` for `board`; quick if they are already built.
fn programs(board: Board, kind: Kind) -> Programs {
    kind.programs(board)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// Runs a test of whole runs, unless it has passed with the same programs.
fn unless_unchanged(name: &str, kind: Kind, test: impl FnOnce()) {
    let programs = [Board::Host, Board::Qemu].map(|board| programs(board, kind));
    unchanged::unless_unchanged(name, programs.iter().flat_map(unchanged::nodes), test);
}

/// The runs that a test makes: with `TAUTRACK_SWEEPS=1` all of them, else the first one.
fn tried<T>(runs: &[T]) -> &[T] {
    if unchanged::complete() {
        runs
    } else {
        &runs[..1]
    }
}

/// Loads a shipped scenario and changes it.
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

/// Runs `scenario` on `board` and prints the summary.
fn outcome(scenario: &Scenario, board: Board) -> (Summary, Vec<Sample>) {
    let options = Options {
        end_when_toppled: true,
        ..Options::default()
    };
    let programs = programs(board, scenario.kind());
    let outcome = run(scenario, &programs, options).unwrap_or_else(|error| panic!("{error}"));
    let summary = Summary::new(scenario, &outcome.facts, &outcome.samples);
    println!("{summary}");
    (summary, outcome.samples)
}

/// Virtual time over which emulated and host nodes are compared, s. It includes homing, arming
/// and the first motion of each robot's task.
const COMPARED_S: f64 = 9.0;

/// Runs the beginning of a shipped scenario with emulated and with nodes in this process, and
/// asserts that plant and frames are bit-identical.
fn ends_in_the_same_bits(name: &str) {
    let beginning = scenario(name, |description| {
        description.duration_s = COMPARED_S;
        description.expect = Expect::default();
        let events = &mut description.operator.events;
        let late = |event: &Event| event.when.after_s.is_some_and(|after| after > COMPARED_S);
        events.truncate(events.iter().position(late).unwrap_or(events.len()));
    });
    let [host, emulated] = [Board::Host, Board::Qemu].map(|board| outcome(&beginning, board).0);
    assert!(host.driven_m > 0.01, "{name} has hardly begun: {host}");
    assert_eq!(host.state_hash, emulated.state_hash, "{name}");
}
