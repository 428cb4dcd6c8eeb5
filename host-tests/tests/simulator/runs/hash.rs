//! Tests of determinism: what the state hash shows, and which changes it detects.

use super::{climb, outcome, scenario, unless_unchanged, with};
use std::path::PathBuf;
use tautrack_host_tests::programs::{Board, Program};
use tautrack_host_tests::robots::NodeName;
use tautrack_host_tests::scenario::{Description, Fault, FaultKind};
use tautrack_host_tests::simulator::run::Options;

/// State hash of the climb up to the first nose.
fn start(change: impl FnOnce(&mut Description)) -> String {
    let short = scenario("staircase", |description| {
        description.duration_s = 12.5;
        description.expect = tautrack_host_tests::scenario::Expect::default();
        change(description);
    });
    outcome(&short, Board::Native).0.state_hash
}

#[test]
fn emulated_and_native_nodes_end_in_the_same_bits_run_after_run() {
    unless_unchanged("hash-of-boards", || {
        let native = &climb(Board::Native).0.state_hash;
        let again = outcome(&scenario("staircase", |_| {}), Board::Native)
            .0
            .state_hash;
        assert_eq!(*native, again, "two native runs");
        assert_eq!(*native, climb(Board::Qemu).0.state_hash, "native and QEMU");
    });
}

#[test]
fn another_seed_and_one_flipped_bit_change_the_hash() {
    unless_unchanged("hash-of-seeds", || {
        let plain = start(|_| {});
        assert_ne!(
            plain,
            start(|description| description.seed += 1),
            "another seed"
        );
        let flip = Fault {
            what: FaultKind::FrameFlip { frame: 100, bit: 0 },
            at_s: 5.0,
            until_s: None,
            notice_within_ms: None,
        };
        assert_ne!(
            plain,
            start(|description| description.faults.push(flip)),
            "one flipped bit"
        );
    });
}

#[test]
fn an_axle_that_answers_a_constant_changes_the_hash_and_fails_the_climb() {
    let path = PathBuf::from(env!("CARGO_BIN_EXE_constant_axle"));
    let program = Program {
        path,
        sha256: String::new(),
    };
    let options = Options {
        exchanged: vec![(NodeName::RIGHT_TRACK, Board::Native, program)],
        ..Options::default()
    };
    let (summary, _) = with(&scenario("staircase", |_| {}), Board::Native, options);
    assert!(!summary.landed && !summary.expectation_met, "{summary}");
    assert_ne!(summary.state_hash, climb(Board::Native).0.state_hash);
}
