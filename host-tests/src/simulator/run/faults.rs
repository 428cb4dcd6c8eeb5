//! Injects the faults of a scenario, and records which node reported each fault first, and when.

use super::listener::{Listener, Notice};
use super::node::Node;
use crate::robots::NodeName;
use crate::scenario::{Fault, FaultKind, Scenario, Switch};
use crate::simulator::bus::Bus;
use crate::simulator::facts::FaultFacts;
use crate::world::TrackFault;
use tautrack::can::Frame;
use tautrack::link::{ChipFault, STEP_US, Sensors};

struct Planned {
    fault: Fault,
    begun: bool,
    ended: bool,
    notice: Option<Notice>,
}

/// Faults of one run.
pub struct Faults {
    planned: Vec<Planned>,
    nodes: Vec<NodeName>,
    seed: u64,
}

impl Faults {
    /// Creates the faults of this scenario, before their start, for a robot with these nodes.
    pub fn new(scenario: &Scenario, nodes: Vec<NodeName>) -> Self {
        let planned = |fault: &Fault| Planned {
            fault: fault.clone(),
            begun: false,
            ended: false,
            notice: None,
        };
        Self {
            planned: scenario.faults.iter().map(planned).collect(),
            nodes,
            seed: scenario.seed,
        }
    }

    /// Adds a fault, which begins at its time.
    pub fn add(&mut self, fault: Fault) {
        self.planned.push(Planned {
            fault,
            begun: false,
            ended: false,
            notice: None,
        });
    }

    /// Lets the fault with this index end at this time.
    pub fn end_at(&mut self, index: usize, until_s: f64) {
        if let Some(planned) = self.planned.get_mut(index) {
            planned.fault.until_s = Some(until_s);
        }
    }

    /// Starts and ends the faults that are due. Returns the numbers of the nodes that restart now.
    pub fn apply(&mut self, time_us: u64, bus: &mut Bus, nodes: &mut [Option<Node>]) -> Vec<usize> {
        let mut starting = Vec::new();
        for planned in &mut self.planned {
            let node = place(&self.nodes, &planned.fault.what);
            let restarts = matches!(planned.fault.what, FaultKind::Restart(_));
            let at_once = restarts.then_some(planned.fault.at_s);
            let until_s = planned.fault.until_s.or(at_once);
            let due = until_s.is_some_and(|until| time_us >= microseconds(until));
            if planned.begun && !planned.ended && due {
                planned.ended = true;
                end(&planned.fault.what, node, self.seed, bus);
                starting.extend(node.filter(|_| restarts));
            }
            // A fault lasts at least one step, so the plant separates the load of a drive that
            // restarts from its old shaft.
            if !planned.begun && time_us >= microseconds(planned.fault.at_s) {
                planned.begun = true;
                begin(&planned.fault.what, node, self.seed, bus, nodes);
            }
        }
        starting
    }

    /// Faults that have begun and not ended.
    fn active(&self) -> impl Iterator<Item = &Fault> {
        let active = |planned: &&Planned| planned.begun && !planned.ended;
        self.planned
            .iter()
            .filter(active)
            .map(|planned| &planned.fault)
    }

    /// Applies the faults of this node's encoder and switches to its sensor values.
    pub fn change(&self, node: usize, sensors: &mut Sensors) {
        for Fault { what, .. } in self.active() {
            if place(&self.nodes, what) != Some(node) {
                continue;
            }
            match *what {
                FaultKind::EncoderFrozen(_) => sensors.encoder_frozen = true,
                FaultKind::SwitchStuck { switch, closed, .. } => {
                    let switches = &mut sensors.switches;
                    *match switch {
                        Switch::Home => &mut switches.home,
                        Switch::PositiveLimit => &mut switches.positive_limit,
                        Switch::NegativeLimit => &mut switches.negative_limit,
                    } = closed;
                }
                _ => {}
            }
        }
    }

    /// Whether the operator is lost.
    pub fn of_operator(&self) -> bool {
        self.active()
            .any(|fault| fault.what == FaultKind::OperatorLost)
    }

    /// Fault of this node's track.
    pub fn of_track(&self, node: usize) -> TrackFault {
        let mut found = TrackFault::NONE;
        for Fault { what, .. } in self.active() {
            match *what {
                _ if place(&self.nodes, what) != Some(node) => {}
                FaultKind::BeltOff(_) => found.belt_off = true,
                FaultKind::SlipperyTrack { friction, .. } => found.friction = friction,
                _ => {}
            }
        }
        found
    }

    /// Forged frames that are sent now.
    pub fn forged(&self, time_us: u64) -> impl Iterator<Item = Frame> {
        self.active().filter_map(move |fault| {
            let FaultKind::Forger {
                id,
                ref data,
                period_ms,
            } = fault.what
            else {
                return None;
            };
            let since_us = time_us.saturating_sub(first_step_us(fault.at_s));
            let due = since_us.is_multiple_of(period_ms * STEP_US);
            Frame::new(id, data).filter(|_| due)
        })
    }

    /// Faults of the sensor chips on the guard's board now. The first one of each chip counts.
    pub fn of_chips(&self) -> [Option<ChipFault>; 3] {
        let mut faults = [None; 3];
        for active in self.active() {
            if let FaultKind::Sensor { chip, fault } = active.what {
                faults[chip as usize].get_or_insert(fault);
            }
        }
        faults
    }

    /// Assigns the new fault reports from the bus to the faults, and logs the faults that started.
    pub fn notice(&mut self, time_us: u64, listener: &mut Listener) {
        let notices = listener.take_notices();
        for planned in &mut self.planned {
            let began_us = microseconds(planned.fault.at_s);
            if planned.begun && time_us == first_step_us(planned.fault.at_s) {
                let node = planned
                    .fault
                    .what
                    .node()
                    .map_or_else(String::new, |node| format!("{node}: "));
                let what = planned.fault.what.words();
                listener.note_injected(format!("fault begins: {node}{what}"));
            }
            if planned.begun && planned.notice.is_none() {
                planned.notice = notices
                    .iter()
                    .find(|notice| notice.time_us >= began_us)
                    .copied();
            }
        }
    }

    /// Returns the facts about each fault.
    pub fn facts(&self) -> Vec<FaultFacts> {
        self.planned.iter().map(facts).collect()
    }
}

fn facts(planned: &Planned) -> FaultFacts {
    let began_us = microseconds(planned.fault.at_s);
    FaultFacts {
        time_s: planned.fault.at_s,
        node: planned.fault.what.node(),
        what: planned.fault.what.words(),
        noticed_by: planned.notice.map(|notice| notice.by.to_string()),
        after_ms: planned
            .notice
            .map(|notice| (notice.time_us - began_us) as f64 * 1e-3),
    }
}

/// Index of the node with the fault, if it is a node of the robot.
fn place(nodes: &[NodeName], what: &FaultKind) -> Option<usize> {
    let befallen = what.node()?;
    nodes.iter().position(|name| *name == befallen)
}

fn begin(
    what: &FaultKind,
    node: Option<usize>,
    seed: u64,
    bus: &mut Bus,
    nodes: &mut [Option<Node>],
) {
    match (what, node) {
        (FaultKind::NodeDead(_) | FaultKind::Restart(_), Some(node)) => {
            nodes[node] = None;
            bus.cut_off(node);
        }
        (FaultKind::BusCut(_), Some(node)) => bus.cut_off(node),
        (FaultKind::FrameLoss { probability }, _) => bus.lose_frames(*probability, seed),
        (FaultKind::FrameFlip { id, frame, bit }, _) => bus.flip_bit(*id, *frame, *bit),
        (
            FaultKind::NodeDead(_)
            | FaultKind::BusCut(_)
            | FaultKind::EncoderFrozen(_)
            | FaultKind::SwitchStuck { .. }
            | FaultKind::Restart(_)
            | FaultKind::Forger { .. }
            | FaultKind::OperatorLost
            | FaultKind::BeltOff(_)
            | FaultKind::SlipperyTrack { .. }
            | FaultKind::Sensor { .. },
            _,
        ) => {}
    }
}

fn end(what: &FaultKind, node: Option<usize>, seed: u64, bus: &mut Bus) {
    match (what, node) {
        (FaultKind::BusCut(_) | FaultKind::Restart(_), Some(node)) => bus.reconnect(node),
        (FaultKind::FrameLoss { .. }, _) => bus.lose_frames(0.0, seed),
        // A dead node stays dead, a flip affects one frame, and `change`, `forged`, `of_chips`,
        // `of_operator` and `of_track` read which other faults are active.
        _ => {}
    }
}

/// Virtual time of the first step in which a fault that begins at `at_s` is active, us.
fn first_step_us(at_s: f64) -> u64 {
    microseconds(at_s).next_multiple_of(STEP_US)
}

fn microseconds(time_s: f64) -> u64 {
    (time_s * 1e6).round() as u64
}
