//! Tests of robots whose home switch or limit switch is stuck.

use super::dead_nodes::at;
use super::{outcome, scenario, unless_unchanged};
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::robots::b2p2::plant::B2p2Parameters;
use tautrack_host_tests::robots::payload::Payload;
use tautrack_host_tests::robots::{NodeName, Robot};
use tautrack_host_tests::scenario::{
    Description, Event, Expect, Fault, FaultKind, OperatorRequest, Switch, When,
};
use tautrack_host_tests::simulator::record::Sample;
use tautrack_host_tests::world::terrain::Terrain;

fn stuck(node: NodeName, switch: Switch, closed: bool, at_s: f64) -> Fault {
    let what = FaultKind::SwitchStuck {
        node,
        switch,
        closed,
    };
    at(at_s, what)
}

/// Runs B2P2 on level ground; it stands unless `change` says otherwise.
fn standing(duration_s: f64, change: impl FnOnce(&mut Description)) -> Vec<Sample> {
    let scenario = scenario("flat", |description| {
        description.duration_s = duration_s;
        description.expect = Expect::default();
        description.operator.speed_mps = 0.0;
        description.operator.chassis_deg = 0.0;
        description.operator.events.clear();
        change(description);
    });
    outcome(&scenario, Board::Host).1
}

fn after(samples: &[Sample], time_s: f64) -> &[Sample] {
    &samples[samples.partition_point(|sample| sample.time_s < time_s)..]
}

/// The robot stands on a slope of 34 degrees, nose up. With a load of 4 kg it would fall backward
/// if the front folded down.
#[test]
fn a_stuck_home_switch_on_a_slope_moves_nothing_that_would_topple_the_robot() {
    unless_unchanged("stuck-home-switch-on-a-slope", || {
        let on_slope = |request, mass_kg: Option<f64>| {
            standing(6.0, |description| {
                description.terrain = Terrain::Slope {
                    angle_deg: 34.0,
                    side_deg: 0.0,
                };
                if let Robot::B2p2(robot) = &mut description.robot {
                    robot.payload = mass_kg.map(|mass_kg| Payload {
                        mass_kg,
                        place_m: [0.14, 0.0, 0.25],
                        from_s: 0.0,
                        declared: true,
                    });
                }
                description.operator.request = Some(request);
                let home = stuck(NodeName::CHASSIS_JOINT, Switch::Home, true, 0.0);
                description.faults = vec![home];
            })
        };
        for request in [OperatorRequest::Arm, OperatorRequest::ArmOffLevel] {
            let samples = on_slope(request, Some(4.0));
            let standing = after(&samples, 1.0);
            let first = &standing[0].truth;
            for sample in standing {
                let truth = &sample.truth;
                assert_eq!(sample.received.guard_state, "ready", "{}", sample.time_s);
                assert!((truth.theta - first.theta).abs() < 0.002, "{truth:?}");
                assert!(
                    (truth.extension - first.extension).abs() < 1e-4,
                    "{truth:?}"
                );
                // The belts creep by 1.4 mm/s under this load.
                assert!(
                    (truth.axle_1[0] - first.axle_1[0]).abs() < 0.01,
                    "{truth:?}"
                );
            }
        }
        // Without the load and with the operator's confirmation, the front folds down.
        let samples = on_slope(OperatorRequest::ArmOffLevel, None);
        let last = &samples.last().expect("samples").truth;
        assert!(last.theta < -0.5 && !last.toppled, "{last:?}");
    });
}

#[test]
fn homing_at_a_stuck_switch_stays_within_the_travel_and_is_reported() {
    unless_unchanged("stuck-home-switch", || {
        let [lowest, highest] = B2p2Parameters::nominal().joint_travel;
        for closed in [true, false] {
            let samples = standing(22.0, |description| {
                let home = stuck(NodeName::CHASSIS_JOINT, Switch::Home, closed, 0.0);
                description.faults = vec![home];
            });
            for Sample { time_s, truth, .. } in &samples {
                let within = lowest - 0.01..=highest + 0.01;
                assert!(within.contains(&truth.theta), "{} {time_s}", truth.theta);
            }
            let mut events = samples.iter().flat_map(|sample| &sample.received.events);
            let failed = "chassis_joint: homing failed (0x8613)";
            assert!(events.any(|event| event.text == failed), "{closed}");
            let state = &samples.last().expect("samples").received.guard_state;
            assert_eq!(state, "held", "{closed}");
        }
    });
}

/// The joint turns up by 30 degrees and back. A taut belt needs 13 mm more of the screw there.
#[test]
fn a_screw_whose_limit_switch_is_closed_does_not_go_on_outward() {
    unless_unchanged("stuck-limit-switch", || {
        let longest = |faults: Vec<Fault>| {
            let samples = standing(9.0, |description| {
                let turn = |time_s: f64, chassis_deg: f64| Event {
                    when: When {
                        time_s: Some(time_s),
                        ..When::default()
                    },
                    chassis_deg: Some(chassis_deg),
                    ..Event::default()
                };
                description.operator.events = vec![turn(5.5, 30.0), turn(7.0, -10.0)];
                description.faults = faults;
            });
            let later = after(&samples, 5.0);
            let extensions = later.iter().map(|sample| sample.truth.extension);
            extensions.fold(0.0, f64::max) - later[0].truth.extension
        };
        let free = longest(vec![]);
        assert!(free > 0.01, "{free} m");
        let limited = longest(vec![stuck(
            NodeName::SCREW,
            Switch::PositiveLimit,
            true,
            5.0,
        )]);
        assert!(limited < 0.001, "{limited} m");
    });
}
