//! Tests of a guard that loses its power and restarts in the middle of a run.

use super::{outcome, scenario};
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::robots::NodeName;
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
    let (summary, samples) = outcome(&restarting(None), Board::Native);
    let armed = |time_s: f64| {
        let sample = samples.iter().find(|sample| sample.time_s >= time_s);
        sample.is_some_and(|sample| sample.received.guard_state == "armed")
    };
    assert!(armed(4.95), "{summary}");
    assert!(leaves_armed(&samples, 5.0), "{summary}");
    let (again, _) = outcome(&restarting(None), Board::Native);
    assert_eq!(summary.state_hash, again.state_hash);
    let (emulated, _) = outcome(&restarting(None), Board::Qemu);
    assert_eq!(summary.state_hash, emulated.state_hash);
}

#[test]
fn a_guard_without_power_is_silent_until_it_starts_again() {
    let (_, samples) = outcome(&restarting(Some(0.5)), Board::Native);
    let state_at = |time_s: f64| {
        let sample = samples.iter().find(|sample| sample.time_s >= time_s);
        sample.map_or("", |sample| sample.received.guard_state.as_str())
    };
    // The last received state stays until the guard sends again.
    assert_eq!(state_at(5.49), "armed");
    assert!(leaves_armed(&samples, 5.5));
}

/// Whether the guard reports another state than "armed" after `from_s`.
fn leaves_armed(samples: &[Sample], from_s: f64) -> bool {
    let later = samples.iter().filter(|sample| sample.time_s > from_s);
    let mut events = later.flat_map(|sample| &sample.received.events);
    events.any(|event| event.text.starts_with("guard: ") && event.text != "guard: armed")
}
