//! Compares the events and the summary of each shipped scenario with stored snapshots. After an
//! intended change, `TAUTRACK_ACCEPT=1 cargo test -p tautrack-host-tests --test simulator snapshot`
//! writes new ones.

use super::{outcome, programs, scenario};
use crate::unchanged::{self, unless_unchanged};
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::programs::setup::checkout;

const SCENARIOS: [&str; 5] = [
    "flat",
    "staircase",
    "staircase-front-kept-up",
    "staircase-k080",
    "node-dies-mid-climb",
];

#[test]
fn shipped_scenarios_say_what_they_said_before() {
    let files = SCENARIOS.map(file);
    let stored = files.map(|file| fs::read_to_string(file).unwrap_or_default());
    let nodes = unchanged::nodes(programs(Board::Host));
    let inputs = nodes.into_iter().chain(stored);
    unless_unchanged("snapshots", inputs, compare);
}

/// The stored snapshot of a scenario.
fn file(name: &str) -> PathBuf {
    let root = checkout::root().unwrap_or_else(|error| panic!("{error}"));
    let folder = root.join("host-tests/snapshots");
    folder.join(name).with_extension("txt")
}

fn compare() {
    let mut differing = Vec::new();
    for name in SCENARIOS {
        let (summary, samples) = outcome(&scenario(name, |_| {}), Board::Host);
        assert!(summary.expectation_met, "{summary}");
        let mut text = String::new();
        for sample in &samples {
            for event in &sample.received.events {
                writeln!(text, "{:7.2} s  {event}", sample.time_s).expect("a string takes all");
            }
        }
        // Wall-clock time differs from computer to computer, and the hashes differ from build to
        // build.
        for line in summary
            .to_string()
            .lines()
            .filter(|line| !line.contains("real time") && !line.contains("hash"))
        {
            writeln!(text, "{line}").expect("a string takes all");
        }
        let file = file(name);
        if std::env::var_os("TAUTRACK_ACCEPT").is_some() {
            fs::write(&file, &text).expect("the snapshot is written");
        }
        let expected = fs::read_to_string(&file).unwrap_or_default();
        if text != expected {
            differing.push(format!("{}:\n{text}", file.display()));
        }
    }
    assert!(
        differing.is_empty(),
        "other than before:\n{}",
        differing.join("\n")
    );
}
