//! Tests of determinism: what the state hash shows, and which changes it detects.

use super::{climb, outcome, scenario, unless_unchanged, with};
use std::path::PathBuf;
use tautrack_host_tests::programs::{Board, Program};
use tautrack_host_tests::results::summary::Summary;
use tautrack_host_tests::robots::NodeName;
use tautrack_host_tests::scenario::{Description, Expect, Fault, FaultKind};
use tautrack_host_tests::simulator::run::Options;
use tautrack_host_tests::world::terrain::Terrain;

/// The first seconds of a climb: homing, arming, approach and the first nose.
fn start(board: Board, change: impl FnOnce(&mut Description)) -> Summary {
    let short = scenario("staircase", |description| {
        description.duration_s = 8.0;
        description.expect = Expect::default();
        if let Terrain::Stairs { first_nose_m, .. } = &mut description.terrain {
            *first_nose_m = 0.85;
        }
        change(description);
    });
    outcome(&short, board).0
}

#[test]
fn emulated_and_native_nodes_end_in_the_same_bits_run_after_run() {
    unless_unchanged("hash-of-boards", || {
        let [native, again] = [(); 2].map(|()| start(Board::Native, |_| {}));
        assert!(native.driven_m > 0.3, "{native}");
        assert_eq!(native.state_hash, again.state_hash, "two native runs");
        let emulated = start(Board::Qemu, |_| {});
        assert!(emulated.nodes.iter().all(|node| node.board == "mps2"));
        assert_eq!(native.state_hash, emulated.state_hash, "native and QEMU");
    });
}

#[test]
fn another_seed_and_one_flipped_bit_change_the_hash() {
    unless_unchanged("hash-of-seeds", || {
        let start = |change: &dyn Fn(&mut Description)| start(Board::Native, change).state_hash;
        let plain = start(&|_| {});
        assert_ne!(plain, start(&|changed| changed.seed += 1), "another seed");
        let flip = Fault {
            what: FaultKind::FrameFlip {
                id: None,
                frame: 100,
                bit: 0,
            },
            at_s: 5.0,
            until_s: None,
            notice_within_ms: None,
        };
        let flipped = start(&|changed| changed.faults.push(flip.clone()));
        assert_ne!(plain, flipped, "one flipped bit");
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
