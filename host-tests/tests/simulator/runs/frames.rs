//! Tests of frames that nobody should have sent: forged ones, and the operator's with a flipped
//! bit.

use super::dead_nodes::at;
use super::{outcome, scenario, unless_unchanged};
use std::f64::consts::TAU;
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::results::summary::Summary;
use tautrack_host_tests::robots::NodeName;
use tautrack_host_tests::scenario::{Expect, Fault, FaultKind};
use tautrack_host_tests::simulator::record::Sample;

/// Time at which the forger begins, s.
const FORGED_S: f64 = 4.5;

fn forger(id: u16, data: &[u8], period_ms: u64) -> FaultKind {
    FaultKind::Forger {
        id,
        data: data.to_vec(),
        period_ms,
    }
}

/// Motion of the joint at rest at this angle: 2^-32 turn as `i32`, and a velocity of 0.
fn motion(angle: f64) -> [u8; 8] {
    let position = (angle / TAU * 2_f64.powi(32)).round() as i32;
    let mut data = [0; 8];
    data[..4].copy_from_slice(&position.to_le_bytes());
    data
}

/// Runs an armed robot on level ground with these faults, of which the last one is the forger.
/// Asserts that a node reports the forger within 20 ms, with one of the words of `reports`, and
/// that the robot is held and the screw moves by 1 mm at most.
fn forged(faults: Vec<Fault>, reports: &[&str]) {
    let text = faults.last().expect("a forger").what.words();
    let scenario = scenario("flat", |description| {
        description.duration_s = 6.0;
        description.expect = Expect::default();
        description.faults = faults;
    });
    let (summary, samples) = outcome(&scenario, Board::Host);
    let first = samples.partition_point(|sample| sample.time_s < FORGED_S);
    let (before, later) = samples.split_at(first);
    let fault = summary.faults.last().expect("the forger");
    assert!(
        fault.after_ms.is_some_and(|after| after <= 20.0),
        "{text} {summary}"
    );
    let events = later.iter().flat_map(|sample| &sample.received.events);
    let events: Vec<&str> = events.map(|event| event.text.as_str()).collect();
    for report in reports {
        assert!(
            events.contains(report),
            "{text}: {report} not in {events:?}"
        );
    }
    let state = &later.last().expect("samples").received.guard_state;
    assert_eq!(state, "held", "{text}");
    let start = before.last().expect("samples").truth.extension;
    for Sample { time_s, truth, .. } in later {
        let moved = (truth.extension - start).abs();
        assert!(moved < 0.001, "{text} {moved} m at {time_s} s");
    }
}

#[test]
fn a_forged_place_of_the_joint_moves_the_screw_by_less_than_1_mm_and_is_reported() {
    unless_unchanged("forged-joint", || {
        let reports = [
            "chassis_joint: identifier sent twice (0x8150)",
            "screw: identifier sent twice (0x8150)",
        ];
        for period_ms in [1, 4, 7, 10] {
            for held in [false, true] {
                let dead = at(3.5, FaultKind::NodeDead(NodeName::LEFT_TRACK));
                let forger = at(FORGED_S, forger(0x184, &motion(1.0), period_ms));
                let faults = held.then_some(dead).into_iter().chain([forger]);
                forged(faults.collect(), &reports);
            }
        }
    });
}

#[test]
fn a_forger_who_replaces_a_dead_joint_moves_the_screw_by_less_than_1_mm() {
    unless_unchanged("forged-dead-joint", || {
        for period_ms in [1, 4] {
            let dead = at(FORGED_S, FaultKind::NodeDead(NodeName::CHASSIS_JOINT));
            let forger = at(FORGED_S, forger(0x184, &motion(1.0), period_ms));
            forged(
                vec![dead, forger],
                &["screw: identifier sent twice (0x8150)"],
            );
        }
    });
}

#[test]
fn forged_motions_of_a_track_and_forged_heartbeats_are_reported() {
    unless_unchanged("forged-heartbeats", || {
        let track = "left_track: identifier sent twice (0x8150)";
        let joint = "chassis_joint: identifier sent twice (0x8150)";
        let guard = "guard: second master (0xff03) of guard";
        for (id, data, report) in [
            (0x182, &motion(1.0)[..], track),
            (0x704, &[5], joint),
            (0x701, &[5], guard),
        ] {
            for period_ms in [4, 50] {
                forged(vec![at(FORGED_S, forger(id, data, period_ms))], &[report]);
            }
        }
    });
}

/// Holds the robot on the stairs, where its left track has restarted at 14 s. From 15.5 s on,
/// `bit` of the request is flipped in `count` of the operator's commands to arm.
fn flipped(bit: u8, count: u32) -> (Summary, Vec<Sample>) {
    let faulty = scenario("node-dies-mid-climb", |description| {
        description.duration_s = 16.5;
        description.faults = vec![at(14.0, FaultKind::Restart(NodeName::LEFT_TRACK))];
        let flips = (0..count).map(|number| {
            let flip = FaultKind::FrameFlip {
                id: Some(0x201),
                frame: 0,
                bit: 48 + bit,
            };
            at(15.5 + 0.02 * f64::from(number), flip)
        });
        description.faults.extend(flips);
    });
    outcome(&faulty, Board::Host)
}

/// Greatest distance that the centre of gravity moves along the stairs after the flip, m, and the
/// guard's states in that time.
fn afterwards(samples: &[Sample]) -> (f64, Vec<&str>) {
    let later = &samples[samples.partition_point(|sample| sample.time_s < 15.5)..];
    let start = later[0].truth.cog[0];
    let moved = later
        .iter()
        .map(|sample| (sample.truth.cog[0] - start).abs());
    let mut states: Vec<_> = later
        .iter()
        .map(|sample| sample.received.guard_state.as_str())
        .collect();
    states.dedup();
    (moved.fold(0.0, f64::max), states)
}

#[test]
fn one_flipped_bit_in_the_operators_request_neither_resets_nor_disarms_a_robot_on_stairs() {
    unless_unchanged("flipped-requests", || {
        // Arm is 1: bit 0 makes it "disarm", and bit 1 "reset".
        for (bit, effect) in [(0, "disarm"), (1, "reset")] {
            let (summary, samples) = flipped(bit, 1);
            let (moved, states) = afterwards(&samples);
            assert_eq!(states, ["held"], "{effect} {summary}");
            assert!(moved < 0.005, "{effect} {moved} m {summary}");
            // Five in a row are a request: the motors are off, or the fault is cleared.
            let (_, samples) = flipped(bit, 5);
            let (moved, states) = afterwards(&samples);
            let follows = moved > 0.008 || states.contains(&"ready");
            assert!(follows, "{effect} {moved} m {states:?}");
        }
    });
}
