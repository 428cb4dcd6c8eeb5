//! The bus is disturbed in the middle of the climb: a cut of it, lost frames, a babbling node, a
//! second producer of SYNC, and network management by somebody else. docs/bus.md has the reactions.

use super::dead_nodes::holds;
use super::{outcome, scenario, unless_unchanged};
use crate::unchanged::complete;
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::robots::NodeName;
use tautrack_host_tests::scenario::{Expect, Fault, FaultKind};

/// Time at which a disturbance begins, s: the robot is on the stairs.
const BEGINS_S: f64 = 14.0;

/// What the robot does.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Reaction {
    /// It climbs on and lands.
    Lands,
    /// A node reports it, and the robot stands and holds.
    Holds,
}
use Reaction::{Holds, Lands};

struct Disturbance {
    name: &'static str,
    begins_s: f64,
    what: FaultKind,
    /// How long it lasts, s.
    lasts_s: f64,
    reaction: Reaction,
}

fn forged(id: u16, data: &[u8], period_ms: u64) -> FaultKind {
    FaultKind::Forger {
        id,
        data: data.to_vec(),
        period_ms,
    }
}

const EVER: f64 = f64::INFINITY;

#[rustfmt::skip] // a row is a line
fn disturbances() -> Vec<Disturbance> {
    let track = NodeName::LEFT_TRACK;
    let joint = NodeName::CHASSIS_JOINT;
    let guard = NodeName::GUARD;
    let loss = |probability| FaultKind::FrameLoss { probability };
    let once = 60_000;
    let row = |name, what, lasts_s, reaction| Disturbance {
        name,
        begins_s: BEGINS_S,
        what,
        lasts_s,
        reaction,
    };
    let from_power_up = |name, probability, reaction| Disturbance {
        begins_s: 0.0,
        ..row(name, loss(probability), EVER, reaction)
    };
    vec![
        from_power_up("1 % is lost from power-up on", 0.01, Lands),
        from_power_up("3 % are lost from power-up on", 0.03, Holds),
        from_power_up("10 % are lost from power-up on", 0.1, Holds),
        from_power_up("30 % are lost from power-up on", 0.3, Holds),
        row("a track is cut off for 50 ms", FaultKind::BusCut(track), 0.05, Holds),
        row("a track is cut off for 500 ms", FaultKind::BusCut(track), 0.5, Holds),
        row("the joint is cut off for 50 ms", FaultKind::BusCut(joint), 0.05, Holds),
        row("the joint is cut off for 500 ms", FaultKind::BusCut(joint), 0.5, Holds),
        row("the guard is cut off for 50 ms", FaultKind::BusCut(guard), 0.05, Holds),
        row("the guard is cut off for 500 ms", FaultKind::BusCut(guard), 0.5, Holds),
        row("1 % of the frames is lost", loss(0.01), EVER, Lands),
        row("3 % of the frames are lost", loss(0.03), EVER, Holds),
        row("10 % of the frames are lost", loss(0.1), EVER, Holds),
        row("30 % of the frames are lost", loss(0.3), EVER, Holds),
        row("a node babbles at the highest priority", forged(0x001, &[0; 8], 1), EVER, Lands),
        row("a node babbles at a priority between", forged(0x3ff, &[0; 8], 1), EVER, Lands),
        row("a node babbles at the lowest priority", forged(0x7ff, &[0; 8], 1), EVER, Lands),
        row("a second producer of SYNC", forged(0x080, &[], 4), EVER, Holds),
        row("a second producer of SYNC, slower", forged(0x080, &[], 10), EVER, Holds),
        row("stop of a track by another node", forged(0x000, &[2, 2], once), EVER, Holds),
        row("pre-operational of the joint", forged(0x000, &[128, 4], once), EVER, Holds),
        row("reset of communication of the screw", forged(0x000, &[130, 5], once), EVER, Holds),
        row("reset of a track", forged(0x000, &[129, 2], once), EVER, Holds),
        row("reset of the joint", forged(0x000, &[129, 4], once), EVER, Holds),
        row("reset of all nodes", forged(0x000, &[129, 0], once), EVER, Holds),
        row("stop of the guard", forged(0x000, &[2, 1], once), EVER, Holds),
    ]
}

#[test]
fn a_disturbed_bus_has_the_reaction_of_the_page_and_topples_nothing() {
    unless_unchanged("disturbed-bus", || {
        let all = disturbances();
        let tried = if complete() { &all[..] } else { &all[18..20] };
        let mut wrong = Vec::new();
        for disturbance in tried {
            let Disturbance {
                name,
                begins_s,
                what,
                lasts_s,
                reaction,
            } = disturbance;
            let until_s = lasts_s.is_finite().then_some(begins_s + lasts_s);
            let disturbed = scenario("staircase", |description| {
                description.expect = Expect::default();
                description.faults = vec![Fault {
                    what: what.clone(),
                    at_s: *begins_s,
                    until_s,
                    notice_within_ms: None,
                }];
            });
            let (summary, samples) = outcome(&disturbed, Board::Host);
            let fault = &summary.faults[0];
            assert!(!summary.toppled, "{name}: {summary}");
            let got = if summary.landed { Lands } else { Holds };
            if got != *reaction {
                wrong.push(*name);
            } else if got == Holds {
                let after_ms = fault
                    .after_ms
                    .unwrap_or_else(|| panic!("{name}: {summary}"));
                holds(&summary, &samples, begins_s + after_ms * 1e-3);
            }
        }
        assert!(wrong.is_empty(), "{wrong:#?}");
    });
}
