//! Tests of determinism: what the state hash shows, and which changes it detects.

use super::{outcome, programs, scenario, unless_unchanged, with};
use tautrack_host_tests::programs::Board;
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
fn emulated_nodes_and_those_in_this_process_end_in_the_same_bits_run_after_run() {
    unless_unchanged("hash-of-boards", || {
        let [host, again] = [(); 2].map(|()| start(Board::Host, |_| {}));
        assert!(host.driven_m > 0.3, "{host}");
        assert_eq!(host.state_hash, again.state_hash, "two runs");
        let emulated = start(Board::Qemu, |_| {});
        assert!(emulated.nodes.iter().all(|node| node.board == "mps2"));
        assert_eq!(host.state_hash, emulated.state_hash, "host and QEMU");
    });
}

#[test]
fn another_seed_and_one_flipped_bit_change_the_hash() {
    unless_unchanged("hash-of-seeds", || {
        let start = |change: &dyn Fn(&mut Description)| start(Board::Host, change).state_hash;
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
fn single_nodes_can_be_emulated() {
    unless_unchanged("one-emulated-node", || {
        let emulated = || Options {
            exchanged: vec![(
                NodeName::RIGHT_TRACK,
                Board::Qemu,
                programs(Board::Qemu).nodes.clone(),
            )],
            ..Options::default()
        };
        let short = scenario("flat", |changed| changed.duration_s = 4.0);
        let (mixed, _) = with(&short, Board::Host, emulated());
        let (alone, _) = outcome(&short, Board::Host);
        assert_eq!(mixed.state_hash, alone.state_hash);
    });
}
