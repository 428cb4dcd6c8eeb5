//! Tests of whole runs: node programs, bus, plant and operator together.

mod clearance;
mod client;
mod climb;
mod dead_nodes;
mod disturbances;
mod feed_forward;
mod frames;
mod guard;
mod hash;
mod image;
mod pace;
mod releasing;
mod restart;
mod sensor_errors;
mod sensors;
mod snapshot;
mod state;
mod switches;
mod tension;

use crate::unchanged;
use std::path::PathBuf;
use std::sync::OnceLock;
use tautrack_host_tests::programs::setup::checkout;
use tautrack_host_tests::programs::{Board, Programs};
use tautrack_host_tests::results::summary::Summary;
use tautrack_host_tests::robots::Kind;
use tautrack_host_tests::scenario::{Description, Scenario};
use tautrack_host_tests::simulator::record::Sample;
use tautrack_host_tests::simulator::run::{Options, Outcome, run};

/// Returns the programs for `board`, which are built once.
fn programs(board: Board) -> &'static Programs {
    static OF_BOARDS: [OnceLock<Programs>; 2] = [const { OnceLock::new() }; 2];
    OF_BOARDS[board as usize].get_or_init(|| {
        Kind::B2p2
            .programs(board)
            .unwrap_or_else(|error| panic!("{error}"))
    })
}

/// Runs a test of whole runs, unless it has passed with the same programs.
fn unless_unchanged(name: &str, test: impl FnOnce()) {
    if let Some(_stamp) = stamp(name) {
        test();
    }
}

/// Stamp of a test of whole runs, see [`unchanged::stamp_of_runs`].
fn stamp(name: &str) -> Option<unchanged::Stamp> {
    let programs = [Board::Host, Board::Qemu].map(programs);
    unchanged::stamp_of_runs(name, programs.into_iter().flat_map(unchanged::nodes))
}

/// Loads a shipped scenario and changes it.
fn scenario(name: &str, change: impl FnOnce(&mut Description)) -> Scenario {
    let mut description = Scenario::load(&path(name))
        .expect("shipped scenarios are good")
        .description();
    change(&mut description);
    description
        .check()
        .unwrap_or_else(|problem| panic!("{problem}"))
}

/// Path of a shipped scenario.
fn path(name: &str) -> PathBuf {
    let root = checkout::root().unwrap_or_else(|error| panic!("{error}"));
    root.join("host-tests/scenarios")
        .join(name)
        .with_extension("toml")
}

/// Returns the nominal climb with `board`'s programs, which runs once for all tests.
fn climb(board: Board) -> &'static (Summary, Vec<Sample>) {
    static OF_BOARDS: [OnceLock<(Summary, Vec<Sample>)>; 2] = [const { OnceLock::new() }; 2];
    OF_BOARDS[board as usize].get_or_init(|| outcome(&scenario("staircase", |_| {}), board))
}

/// Runs `scenario` with `board`'s programs.
fn outcome(scenario: &Scenario, board: Board) -> (Summary, Vec<Sample>) {
    with(scenario, board, Options::default())
}

fn with(scenario: &Scenario, board: Board, options: Options) -> (Summary, Vec<Sample>) {
    let Outcome { samples, facts, .. } =
        run(scenario, programs(board), options).unwrap_or_else(|error| panic!("{error}"));
    (Summary::new(scenario, &facts, &samples), samples)
}
