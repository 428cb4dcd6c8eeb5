//! Tests with nodes that die, have a frozen encoder, or are cut off from the bus in the middle of
//! the climb.

use super::{outcome, scenario, unless_unchanged};
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::results::summary::Summary;
use tautrack_host_tests::robots::NodeName;
use tautrack_host_tests::robots::b2p2::nodes::NODES;
use tautrack_host_tests::scenario::{Expect, Fault, FaultKind};
use tautrack_host_tests::simulator::record::Sample;

/// Maximum time until another node reports the fault, ms.
const NOTICE_MS: f64 = 150.0;

/// A node is gone in the emulator in another way than a process is.
#[test]
fn a_dead_emulated_track_is_noticed_in_time() {
    unless_unchanged("dead-track", || {
        let standing = scenario("flat", |description| {
            description.duration_s = 5.0;
            description.expect = Expect::default();
            description.faults = vec![at(4.5, FaultKind::NodeDead(NodeName::LEFT_TRACK))];
        });
        let (summary, _) = outcome(&standing, Board::Qemu);
        let fault = &summary.faults[0];
        assert_eq!(fault.node, Some(NodeName::LEFT_TRACK));
        assert!(
            fault.after_ms.is_some_and(|after| after <= NOTICE_MS),
            "{summary}"
        );
    });
}

#[test]
fn whichever_node_dies_another_one_notices_in_time_and_the_robot_holds() {
    unless_unchanged("dead-nodes", || {
        for (node, _) in NODES {
            let (summary, samples) = with_fault(FaultKind::NodeDead(node));
            let fault = &summary.faults[0];
            assert!(
                fault.after_ms.is_some_and(|after| after <= NOTICE_MS),
                "{node}: {summary}"
            );
            assert_ne!(
                fault.noticed_by.as_deref(),
                Some(node.as_str()),
                "the dead do not speak"
            );
            holds(&summary, &samples, fault.time_s);
        }
    });
}

#[test]
fn a_node_cut_off_from_the_bus_holds_like_a_dead_one() {
    unless_unchanged("cut-off-nodes", || {
        for node in [
            NodeName::RIGHT_TRACK,
            NodeName::CHASSIS_JOINT,
            NodeName::GUARD,
        ] {
            let (summary, samples) = with_fault(FaultKind::BusCut(node));
            let fault = &summary.faults[0];
            assert!(
                fault.after_ms.is_some_and(|after| after <= NOTICE_MS),
                "{node}: {summary}"
            );
            holds(&summary, &samples, fault.time_s);
        }
    });
}

#[test]
fn a_frozen_encoder_is_found_and_does_not_run_away() {
    unless_unchanged("frozen-encoder", || {
        let (summary, samples) = with_fault(FaultKind::EncoderFrozen(NodeName::LEFT_TRACK));
        let fault = &summary.faults[0];
        assert_eq!(fault.noticed_by.as_deref(), Some("left_track"), "{summary}");
        assert!(
            fault.after_ms.is_some_and(|after| after <= 1_000.0),
            "{summary}"
        );
        holds(&summary, &samples, fault.time_s);
    });
}

pub(super) fn at(at_s: f64, what: FaultKind) -> Fault {
    Fault {
        what,
        at_s,
        until_s: None,
        notice_within_ms: None,
    }
}

pub(super) fn with_fault(what: FaultKind) -> (Summary, Vec<Sample>) {
    let faulty = scenario("node-dies-mid-climb", |description| {
        description.duration_s = 17.5;
        description.faults = vec![at(14.0, what)];
    });
    outcome(&faulty, Board::Host)
}

/// Asserts that from two seconds after the fault on, nothing moves and the robot stands on its
/// tracks.
pub(super) fn holds(summary: &Summary, samples: &[Sample], fault_s: f64) {
    assert!(!summary.toppled, "{summary}");
    for sample in samples
        .iter()
        .filter(|sample| sample.time_s > fault_s + 2.0)
    {
        let truth = &sample.truth;
        assert!(
            truth.ground_speed.abs() < 0.02,
            "{} m/s at {} s\n{summary}",
            truth.ground_speed,
            sample.time_s
        );
        assert!(
            truth.belt_speed.iter().all(|speed| speed.abs() < 0.02),
            "{:?} at {} s",
            truth.belt_speed,
            sample.time_s
        );
    }
}
