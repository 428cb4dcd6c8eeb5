//! Tests of nodes that lose their power and restart in the middle of a run.

use super::dead_nodes::{holds, with_fault};
use super::{outcome, scenario, unless_unchanged};
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::robots::NodeName;
use tautrack_host_tests::robots::b2p2::nodes::NODES;
use tautrack_host_tests::scenario::{Expect, Fault, FaultKind, Scenario};
use tautrack_host_tests::simulator::record::Sample;

fn restarting(off_s: Option<f64>) -> Scenario {
    scenario("flat", |description| {
        description.duration_s = 6.0;
        description.expect = Expect::default();
        description.faults = vec![Fault {
            what: FaultKind::Restart(NodeName::GUARD),
            at_s: 5.0,
            until_s: off_s.map(|off| 5.0 + off),
            notice_within_ms: None,
        }];
    })
}

#[test]
fn a_guard_that_restarts_begins_from_its_power_up_and_a_run_with_it_is_bit_identical() {
    let (summary, samples) = outcome(&restarting(None), Board::Host);
    let armed = |time_s: f64| {
        let sample = samples.iter().find(|sample| sample.time_s >= time_s);
        sample.is_some_and(|sample| sample.received.guard_state == "armed")
    };
    assert!(armed(4.95), "{summary}");
    assert!(leaves_armed(&samples, 5.0), "{summary}");
    let (again, _) = outcome(&restarting(None), Board::Host);
    assert_eq!(summary.state_hash, again.state_hash);
    let (emulated, _) = outcome(&restarting(None), Board::Qemu);
    assert_eq!(summary.state_hash, emulated.state_hash);
}

#[test]
fn a_guard_without_power_is_silent_until_it_starts_again() {
    let (_, samples) = outcome(&restarting(Some(0.5)), Board::Host);
    let state_at = |time_s: f64| {
        let sample = samples.iter().find(|sample| sample.time_s >= time_s);
        sample.map_or("", |sample| sample.received.guard_state.as_str())
    };
    // The last received state stays until the guard sends again.
    assert_eq!(state_at(5.49), "armed");
    assert!(leaves_armed(&samples, 5.5));
}

/// The robot climbs, and rocks on the edge of a step when it stops.
#[test]
fn whichever_node_restarts_on_the_stairs_the_robot_holds_until_the_operators_reset() {
    unless_unchanged("restarting-nodes", || {
        for (node, _) in NODES {
            let (summary, samples) = with_fault(FaultKind::Restart(node));
            let fault = &summary.faults[0];
            holds(&summary, &samples, fault.time_s);
            let first = samples.partition_point(|sample| sample.time_s < fault.time_s);
            let start = &samples[first - 1].truth;
            for Sample {
                time_s,
                truth,
                received,
                ..
            } in &samples[first..]
            {
                let joint = (truth.theta - start.theta).abs();
                let screw = (truth.extension - start.extension).abs();
                let robot = (truth.cog[0] - start.cog[0]).abs();
                assert!(joint < 0.05, "{node}: {joint} rad at {time_s} s");
                assert!(screw < 0.001, "{node}: {screw} m at {time_s} s");
                assert!(robot < 0.03, "{node}: {robot} m at {time_s} s");
                let waited = *time_s > fault.time_s + 0.1;
                assert!(!waited || received.guard_state != "armed", "{node}");
            }
            if node != NodeName::GUARD {
                let in_time = fault.after_ms.is_some_and(|after| after <= 20.0);
                assert!(in_time, "{summary}");
                let named = format!("guard: node lost (0xff02) of {node}");
                let mut events = samples.iter().flat_map(|sample| &sample.received.events);
                assert!(events.any(|event| event.text == named), "{node}");
            }
        }
    });
}

/// Whether the guard reports another state than "armed" after `from_s`.
fn leaves_armed(samples: &[Sample], from_s: f64) -> bool {
    let later = samples.iter().filter(|sample| sample.time_s > from_s);
    let mut events = later.flat_map(|sample| &sample.received.events);
    events.any(|event| event.text.starts_with("guard: ") && event.text != "guard: armed")
}
