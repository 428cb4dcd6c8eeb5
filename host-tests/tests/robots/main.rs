//! Whole runs of the other robots: node programs, bus, plant and operator together; one file per robot.

mod crawler;
mod hylos;
mod rt_mover;

use std::path::Path;
use tautrack_host_tests::machines::Kind;
use tautrack_host_tests::nodes::{self, Board, Programs};
use tautrack_host_tests::record::Sample;
use tautrack_host_tests::run::{Options, run};
use tautrack_host_tests::scenario::{Description, Scenario};
use tautrack_host_tests::summary::Summary;

/// The programs of `kind` for `board`; quick when they are built.
fn programs(board: Board, kind: Kind) -> Programs {
    nodes::build(board, kind).unwrap_or_else(|error| panic!("{error}"))
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

/// A shipped scenario from power-up to its end: emulated cores and programs of this computer agree in every bit of the plant and of the frames.
fn ends_in_the_same_bits(name: &str) {
    let whole = scenario(name, |_| {});
    let [native, emulated] = [Board::Native, Board::Qemu].map(|board| outcome(&whole, board).0);
    assert_eq!(native.state_hash, emulated.state_hash, "{name}");
    assert!(emulated.expectation_met, "{emulated}");
}
