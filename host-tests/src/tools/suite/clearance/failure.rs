//! Draws what fails in the middle of a phase.

use crate::robots::NodeName;
use crate::scenario::{Fault, FaultKind, SensorChip};
use crate::simulator::record::Sample;
use crate::tools::suite::draw::generator::Random;
use serde::{Deserialize, Serialize};
use tautrack::link::ChipFault;
use tautrack::robots::b2p2::clearance::Phase;

/// Phases in which something fails, in turn, with the time until which it begins, s: about as long
/// as the phase lasts.
const PHASES: [(Phase, f64); 10] = [
    (Phase::Approach, 3.0),
    (Phase::Climb, 6.0),
    (Phase::Sway, 0.4),
    (Phase::Crest, 0.5),
    (Phase::Land, 0.8),
    (Phase::Descend, 10.0),
    (Phase::Withdraw, 18.0),
    (Phase::Raise, 4.0),
    (Phase::Arch, 4.0),
    (Phase::Haul, 6.0),
];

/// What fails, and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// The phase.
    pub phase: Phase,
    /// How often the phase has begun by then; at most once for most phases.
    pub occasion: u64,
    /// Time after the beginning of the phase, s.
    pub after_s: f64,
    /// How long it lasts, s; `None` for good.
    pub lasts_s: Option<f64>,
    /// What fails.
    pub what: FaultKind,
}

/// What has failed, as a part of a result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Failed {
    /// Phase in which it shall fail.
    pub phase: String,
    /// The fault; `None` if the robot did not get into the phase, or the run ended before.
    pub fault: Option<Fault>,
}

impl Failure {
    /// Draws what fails in the run with this number.
    pub fn draw(random: &mut Random, number: u64) -> Self {
        let (phase, lasts) = PHASES[(number % PHASES.len() as u64) as usize];
        let repeats = matches!(phase, Phase::Climb | Phase::Sway);
        let nodes = [
            NodeName::LEFT_TRACK,
            NodeName::RIGHT_TRACK,
            NodeName::CHASSIS_JOINT,
            NodeName::SCREW,
            NodeName::GUARD,
        ];
        let node = nodes[random.below(nodes.len() as u64) as usize];
        let track = nodes[random.below(2) as usize];
        let friction = random.between(0.05, 0.4);
        let frozen = FaultKind::Sensor {
            chip: SensorChip::Inclinometer,
            fault: ChipFault::Frozen,
        };
        let kinds = [
            (&FaultKind::NodeDead(node), 5.0),
            (&frozen, 2.0),
            (&FaultKind::SlipperyTrack { track, friction }, 3.0),
            (&FaultKind::BeltOff(track), 3.0),
            (&FaultKind::BusCut(node), 2.0),
            (&FaultKind::FrameLoss { probability: 1.0 }, 2.0),
            (&FaultKind::OperatorLost, 2.0),
            (&FaultKind::Restart(node), 1.0),
        ];
        let what = random.weighted(&kinds).unwrap_or(&frozen).clone();
        let passes = !matches!(
            what,
            FaultKind::NodeDead(_) | FaultKind::BeltOff(_) | FaultKind::Restart(_)
        );
        Self {
            phase,
            occasion: if repeats { 1 + random.below(2) } else { 1 },
            after_s: random.between(0.0, lasts),
            lasts_s: (passes && random.coin()).then(|| random.between(0.1, 3.0)),
            what,
        }
    }

    /// Whether only the robot that stands as an arch gets into the phase.
    pub fn arches(&self) -> bool {
        matches!(self.phase, Phase::Raise | Phase::Arch | Phase::Haul)
    }

    /// Whether only an obstacle that is too high leads to the phase.
    pub fn needs_a_high_curb(&self) -> bool {
        self.arches() || self.phase == Phase::Withdraw
    }

    /// Describes it in words.
    pub fn words(&self) -> String {
        let of = self
            .what
            .node()
            .map_or_else(String::new, |node| format!("{node}: "));
        let lasts = self
            .lasts_s
            .map_or_else(String::new, |time_s| format!(" for {time_s} s"));
        format!(
            "{of}{}{lasts}, {} s after {} begins for time {}",
            self.what.words(),
            self.after_s,
            self.phase.name(),
            self.occasion
        )
    }

    /// Returns what chooses the fault from the samples of a run.
    pub fn inject(self) -> impl FnMut(&Sample) -> Option<Fault> {
        let (mut before, mut begun, mut done) = ("", 0, false);
        move |sample| {
            let phase = sample.received.clearance;
            if phase != before && phase == self.phase.name() {
                begun += 1;
            }
            before = phase;
            if done || begun < self.occasion {
                return None;
            }
            done = true;
            let at_s = sample.time_s + self.after_s;
            Some(Fault {
                what: self.what.clone(),
                at_s,
                until_s: self.lasts_s.map(|lasts_s| at_s + lasts_s),
                notice_within_ms: None,
            })
        }
    }
}
