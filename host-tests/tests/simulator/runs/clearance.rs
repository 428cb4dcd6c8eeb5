//! Tests of runs in which B2P2 clears obstacles by itself.

use super::{climb, outcome, programs, scenario, unless_unchanged, with};
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::robots::NodeName;
use tautrack_host_tests::scenario::{
    Clearance, Event, Expect, Fault, FaultKind, OperatorRequest, When,
};
use tautrack_host_tests::simulator::record::Sample;
use tautrack_host_tests::simulator::run::Options;
use tautrack_host_tests::tools::suite::clearance::{self, Ending, Shard};
use tautrack_host_tests::world::terrain::Terrain;

/// First time at which a phase was published, s.
fn begins(samples: &[Sample], phase: &str) -> Option<f64> {
    let first = samples
        .iter()
        .find(|sample| sample.received.clearance == phase);
    first.map(|sample| sample.time_s)
}

/// The scripted operator knows the stairs. The robot alone may need 15 % more time from arming on,
/// and its margins are as wide.
#[test]
fn the_paper_s_stairs_are_climbed_without_a_script() {
    unless_unchanged("clearance-staircase", || {
        let (scripted, _) = climb(Board::Host);
        let (alone, samples) = outcome(&scenario("clearance/staircase", |_| {}), Board::Host);
        assert!(alone.expectation_met, "{:?}", alone.unmet);
        let since_arming = |landed: Option<f64>| landed.expect("it landed") - 2.67;
        let ratio = since_arming(alone.landing_time_s) / since_arming(scripted.landing_time_s);
        assert!(ratio < 1.15, "{ratio}");
        let margin = |summary: &tautrack_host_tests::results::summary::Summary| {
            summary.min_guard_margin_m.expect("it has margins")
        };
        assert!(margin(&alone) > margin(scripted) - 1e-3);
        for phase in ["approach", "climb", "sway", "crest", "land"] {
            assert!(begins(&samples, phase).is_some(), "{phase}");
        }
    });
}

/// With taut belts the robot finds out that the curb is too high.
#[test]
fn a_curb_that_is_too_high_for_taut_belts_is_cleared_with_released_ones() {
    unless_unchanged("clearance-curb", || {
        let (summary, samples) = outcome(&scenario("clearance/curb-30-cm", |_| {}), Board::Host);
        assert!(summary.expectation_met, "{:?}", summary.unmet);
        let [withdraw, arch, haul] =
            ["withdraw", "arch", "haul"].map(|phase| begins(&samples, phase).expect(phase));
        assert!(withdraw < arch && arch < haul);
    });
}

/// An arch that does not reach over the curb climbs its wall. The robot is held while it leans.
#[test]
fn a_curb_that_is_too_high_for_an_arch_is_given_up_before_the_robot_stands_upright() {
    unless_unchanged("clearance-wall", || {
        let scenario = scenario("clearance/curb-30-cm", |description| {
            description.terrain = Terrain::Curb {
                height_m: 0.45,
                nose_m: 1.7,
                depth_m: 3.0,
            };
            description.duration_s = 60.0;
            description.expect = Expect::default();
        });
        let (summary, samples) = outcome(&scenario, Board::Host);
        assert!(!summary.toppled && summary.stopped);
        let last = samples.last().expect("it ran");
        assert_eq!(last.received.clearance, "held");
        assert_eq!(last.received.clearance_cause, "too high");
        assert!(samples.iter().all(|sample| sample.truth.pitch < 1.5));
    });
}

/// A robot whose centre of gravity is too high for an arch goes back to level ground, and stands.
#[test]
fn a_curb_that_is_too_high_is_given_up_on_level_ground() {
    unless_unchanged("clearance-given-up", || {
        let scenario = scenario("clearance/curb-30-cm", |description| {
            description.robot.b2p2_mut().k_m = 1.232;
            description.robot.b2p2_mut().com_offset_m = 0.0;
            description.duration_s = 60.0;
            description.expect = Expect::default();
        });
        let (summary, samples) = outcome(&scenario, Board::Host);
        assert!(!summary.landed && !summary.toppled && summary.stopped);
        let last = samples.last().expect("it ran");
        assert_eq!(last.received.clearance, "given up");
        assert!(last.truth.pitch.abs() < 0.02 && last.truth.axle_1[2] < 0.06);
        assert_eq!(summary.guard.refused, 0);
    });
}

/// In the middle of the climb the operator stops, goes on, and takes over.
#[test]
fn the_operator_stops_the_robot_and_takes_over_at_any_moment() {
    unless_unchanged("clearance-operator", || {
        let scenario = scenario("clearance/staircase", |description| {
            let event = |time_s: f64| Event {
                when: When {
                    time_s: Some(time_s),
                    ..When::default()
                },
                ..Event::default()
            };
            description.expect = Expect::default();
            description.duration_s = 24.0;
            description.operator.chassis_deg = 10.0;
            description.operator.events = vec![
                Event {
                    request: Some(OperatorRequest::Stop),
                    ..event(14.0)
                },
                Event {
                    request: Some(OperatorRequest::Arm),
                    ..event(17.0)
                },
                Event {
                    clearance: Some(Clearance::Manual),
                    speed_mps: Some(0.0),
                    ..event(20.0)
                },
            ];
        });
        let (_, samples) = outcome(&scenario, Board::Host);
        let between = |from: f64, to: f64| {
            samples
                .iter()
                .filter(move |sample| (from..to).contains(&sample.time_s))
        };
        for sample in between(15.0, 17.0) {
            assert!(sample.received.passed_speed.abs() < 1e-9);
            assert!(
                sample
                    .truth
                    .belt_speed
                    .iter()
                    .all(|speed| speed.abs() < 0.02)
            );
        }
        assert!(between(18.0, 20.0).all(|sample| sample.received.passed_speed > 0.1));
        for sample in between(22.0, 24.0) {
            assert!(sample.received.clearance.is_empty());
            assert!((sample.truth.theta.to_degrees() - 10.0).abs() < 1.0);
        }
    });
}

/// Each node dies in the middle of a phase. The guard's own death leaves the phase as it was last
/// published.
#[test]
fn a_node_that_dies_in_any_phase_leaves_the_robot_standing() {
    unless_unchanged("clearance-dead-nodes", || {
        let (_, samples) = outcome(&scenario("clearance/staircase", |_| {}), Board::Host);
        let nodes = [
            NodeName::LEFT_TRACK,
            NodeName::CHASSIS_JOINT,
            NodeName::SCREW,
            NodeName::GUARD,
        ];
        for (phase, node) in ["climb", "sway", "crest", "land"].into_iter().zip(nodes) {
            let at_s = begins(&samples, phase).expect(phase) + 0.1;
            let scenario = scenario("clearance/staircase", |description| {
                description.expect = Expect::default();
                description.duration_s = at_s + 4.0;
                description.faults = vec![Fault {
                    what: FaultKind::NodeDead(node),
                    at_s,
                    until_s: None,
                    notice_within_ms: None,
                }];
            });
            let (summary, samples) = with(&scenario, Board::Host, Options::default());
            let last = samples.last().expect("it ran");
            assert!(!summary.toppled, "{node} in {phase}");
            let speed = last.truth.ground_speed;
            assert!(speed.abs() < 0.02, "{node} in {phase}: {speed}");
            if node != NodeName::GUARD {
                assert_eq!(last.received.clearance, "held", "{node} in {phase}");
                assert_eq!(last.received.clearance_cause, "stopped");
            }
        }
    });
}

/// Ten obstacles of the suite.
#[test]
fn ten_drawn_obstacles_are_cleared_or_given_up_and_none_topples_the_robot() {
    unless_unchanged("clearance-draws", || {
        let plan = (10, 8_000, false);
        let rows =
            clearance::clearance(plan, Shard::WHOLE, programs(Board::Host), &|_, _| {}).unwrap();
        assert_eq!(rows.len(), 10);
        let mut possible = 0;
        for row in &rows {
            println!("{}", clearance::table::progress(row));
            assert_ne!(row.ending, Ending::Toppled, "{}", row.about);
            assert!(!row.missed(), "{}", row.about);
            possible += u32::from(row.margin_mm >= 20.0);
        }
        assert!(possible >= 5, "{possible}");
    });
}

/// Runs with nodes on the emulated processor are bit-identical. It takes minutes.
#[test]
#[ignore = "takes long"]
fn twenty_drawn_obstacles_are_bit_identical_with_emulated_nodes() {
    let [host, emulated] = [Board::Host, Board::Qemu].map(|board| {
        clearance::clearance(
            (20, 9_000, false),
            Shard::WHOLE,
            programs(board),
            &|row, _| {
                println!("{}", clearance::table::progress(row));
            },
        )
        .unwrap()
    });
    assert_eq!(host.len(), 20);
    for (host, emulated) in host.iter().zip(&emulated) {
        assert!(!host.state_hash.is_empty());
        assert_eq!(host, emulated, "{}", host.about);
    }
}

/// Something fails in the middle of each phase.
#[test]
fn a_fault_in_each_phase_topples_no_robot_and_each_run_gets_to_an_end() {
    unless_unchanged("clearance-faults", || {
        let plan = (10, 8_100, true);
        let rows =
            clearance::clearance(plan, Shard::WHOLE, programs(Board::Host), &|_, _| {}).unwrap();
        let mut failed = 0;
        for row in &rows {
            println!("{}", clearance::table::progress(row));
            assert!(!row.missed(), "{:?}: {}", row.ending, row.about);
            let fault = row.failed.as_ref().and_then(|failed| failed.fault.as_ref());
            failed += u32::from(fault.is_some());
        }
        assert!(failed >= 8, "{failed}");
    });
}
