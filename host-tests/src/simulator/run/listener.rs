//! Decodes the frames that nodes publish on the bus, for the operator, the report and the detection
//! of fault reports.

use crate::robots::{NodeName, NodeSpec, Posture, Robot};
use crate::scenario::BusView;
use crate::simulator::record::{Event, Level, Received};
use std::collections::BTreeSet;
use std::f64::consts::TAU;
use tautrack::bus::network::as_emergency;
use tautrack::bus::pdo::{
    BeltStatus, DriveStatus, GuardClearance, GuardMargins, GuardMotion, GuardPassed, GuardPosition,
    GuardState, Payload, transmit,
};
use tautrack::can::Frame;
use tautrack::faults::Fault;
use tautrack::node::guard::State;
use tautrack::robots::b2p2::clearance::{Cause, Phase};
use tautrack::stability::filter::Verdict;
use tautrack::stability::support::Edge;

/// Information that the operator can read from the bus.
#[derive(Clone, Debug, Default)]
pub struct View {
    /// Values that the conditions of a script use.
    pub bus: BusView,
    /// State of the guard; `None` before its first state frame.
    pub state: Option<State>,
    /// Chassis angle that the guard passes on, rad.
    pub passed_theta: f64,
}

/// Fault report that was sent on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Notice {
    /// Node that sent the report.
    pub by: NodeName,
    /// Faulty node that the guard names, if it names one.
    pub about: Option<NodeName>,
    /// Time of the report, us.
    pub time_us: u64,
}

/// Decodes every frame of the bus.
#[derive(Debug)]
pub struct Listener {
    /// Names and ids of the nodes, the guard last.
    nodes: Vec<(NodeName, u8)>,
    stages: &'static [&'static str],
    view: View,
    received: Received,
    posture: Posture,
    fault_report: (u8, u16),
    /// Faults in the log that have not ended: node and code.
    logged: BTreeSet<(u8, u16)>,
    /// Codes of the guard's emergency frames whose node is not known yet, and the number of samples
    /// for which they have waited.
    unnamed: Vec<(u16, u8)>,
    notices: Vec<Notice>,
    /// Number of transitions of the autonomous clearance.
    transitions: u8,
}

/// Number of samples after which a fault of the guard is logged without a node. The guard's state
/// frame should name the node within one SYNC period.
const NAMED_WITHIN: u8 = 5;

impl Listener {
    /// Creates the listener for this robot with these nodes, the guard last.
    pub fn new(nodes: &[NodeSpec], robot: &Robot) -> Self {
        Self {
            nodes: nodes.iter().map(|node| (node.name, node.id)).collect(),
            stages: robot.kind().facts().stages,
            posture: robot.section().posture(),
            view: View::default(),
            received: Received {
                currents: vec![0.0; nodes.len().saturating_sub(1)],
                ..Received::default()
            },
            fault_report: (0, 0),
            logged: BTreeSet::new(),
            unnamed: Vec::new(),
            notices: Vec::new(),
            transitions: 0,
        }
    }

    fn guard(&self) -> u8 {
        self.nodes.last().map_or(0, |node| node.1)
    }

    fn name_of(&self, id: u8) -> Option<NodeName> {
        let node = self.nodes.iter().find(|node| node.1 == id);
        node.map(|node| node.0)
    }

    fn words_for(&self, id: u8) -> String {
        self.name_of(id)
            .map_or_else(|| format!("node {id}"), |name| name.to_string())
    }

    /// Decodes one delivered frame.
    pub fn receive(&mut self, frame: &Frame, time_us: u64) {
        let guard = self.guard();
        if let Some(motion) = GuardMotion::from_frame(frame, transmit(1), guard) {
            let radians = |centidegrees: i16| (f64::from(centidegrees) * 0.01).to_radians();
            self.received.odometry = f64::from(motion.odometry) * 1e-6;
            self.received.pitch = radians(motion.pitch);
            self.received.roll = radians(motion.roll);
        } else if let Some(state) = GuardState::from_frame(frame, transmit(2), guard) {
            self.receive_state(state, time_us);
        } else if let Some(margins) = GuardMargins::from_frame(frame, transmit(3), guard) {
            let GuardMargins {
                back,
                front,
                left,
                right,
            } = margins;
            self.received.margins =
                Some([back, front, left, right].map(|margin| f64::from(margin) * 1e-3));
        } else if let Some(passed) = GuardPassed::from_frame(frame, transmit(4), guard) {
            self.received.asked_speed = f64::from(passed.asked_speed) * 1e-3;
            self.received.passed_speed = f64::from(passed.passed_speed) * 1e-3;
            self.receive_posture(passed.asked_posture, passed.passed_posture);
        } else if let Some(position) = GuardPosition::from_frame(frame, transmit(5), guard) {
            self.receive_position(position);
        } else if let Some(clearance) = GuardClearance::from_frame(frame, transmit(6), guard) {
            self.receive_clearance(clearance);
        } else if let Some(emergency) = as_emergency(frame) {
            self.receive_emergency(emergency.node, emergency.code, time_us);
        } else {
            for (current, (_, id)) in self.received.currents.iter_mut().zip(&self.nodes) {
                if let Some(belts) = BeltStatus::from_frame(frame, transmit(3), *id) {
                    self.received.belt_tension = f64::from(belts.tension) * 0.1;
                }
                if let Some(status) = DriveStatus::from_frame(frame, transmit(2), *id) {
                    *current = f64::from(status.current) * 1e-3;
                }
            }
        }
        self.view.bus.odometry_m = self.received.odometry;
        self.view.bus.pitch = self.received.pitch;
        self.view.bus.heading = self.received.heading;
        self.view.passed_theta = self.received.passed_theta;
    }

    /// Information that the operator can read from the bus.
    pub fn view(&self) -> &View {
        &self.view
    }

    /// Returns the received values for a sample. Each event is returned once.
    pub fn take(&mut self) -> Received {
        for (_, samples) in &mut self.unnamed {
            *samples += 1;
        }
        let waiting = std::mem::take(&mut self.unnamed);
        let (due, waiting): (Vec<_>, Vec<_>) =
            waiting.into_iter().partition(|of| of.1 > NAMED_WITHIN);
        self.unnamed = waiting;
        for (code, _) in due {
            self.note(Level::Error, format!("guard: {}", fault_words(code)));
        }
        let events = std::mem::take(&mut self.received.events);
        Received {
            events,
            ..self.received.clone()
        }
    }

    fn note(&mut self, level: Level, text: String) {
        self.received.events.push(Event {
            level,
            injected: false,
            text,
        });
    }

    /// Adds an event to the next sample: the runner injects a fault.
    pub fn note_injected(&mut self, text: String) {
        self.received.events.push(Event {
            level: Level::Warning,
            injected: true,
            text,
        });
    }

    fn receive_posture(&mut self, asked: i16, passed: i16) {
        let metres = |millimetres: i16| f64::from(millimetres) * 1e-3;
        let posture = &mut self.received.posture;
        match self.posture {
            Posture::None => {}
            Posture::ChassisAngle { .. } => {
                let angles = [asked, passed].map(turn);
                [self.received.asked_theta, self.received.passed_theta] = angles;
                posture.insert("asked_chassis_rad", angles[0]);
                posture.insert("passed_chassis_rad", angles[1]);
            }
            Posture::Clearance { .. } => {
                posture.insert("asked_clearance_m", metres(asked));
                posture.insert("passed_clearance_m", metres(passed));
            }
            Posture::Step => {
                posture.insert("asked_step_m", metres(asked));
            }
        }
    }

    /// Returns the fault reports since the last call.
    pub fn take_notices(&mut self) -> Vec<Notice> {
        std::mem::take(&mut self.notices)
    }

    /// Logs each transition of the autonomous clearance with its cause.
    fn receive_clearance(&mut self, clearance: GuardClearance) {
        let phase = Phase::from_code(clearance.phase).unwrap_or_default();
        let cause = Cause::from_code(clearance.cause).unwrap_or_default();
        self.received.cleared = clearance.cleared;
        self.received.clearance = if phase == Phase::Off {
            ""
        } else {
            phase.name()
        };
        self.received.clearance_cause = cause.words();
        if self.transitions != clearance.transitions {
            self.transitions = clearance.transitions;
            let level = match phase {
                Phase::Withdraw | Phase::GivenUp | Phase::Held => Level::Warning,
                _ => Level::Info,
            };
            self.note(
                level,
                format!("clearance: {} ({})", phase.name(), cause.words()),
            );
        }
    }

    fn receive_state(&mut self, state: GuardState, time_us: u64) {
        self.received.heading = turn(state.heading);
        self.view.state = State::from_code(state.state);
        let name = self
            .view
            .state
            .map_or("unknown", |state| state.name(self.stages));
        if self.received.guard_state != name {
            let level = if self.view.state == Some(State::Held) {
                Level::Warning
            } else {
                Level::Info
            };
            self.note(level, format!("guard: {name}"));
            self.received.guard_state = name.to_string();
        }
        self.received.verdict =
            Verdict::from_code(state.verdict).map_or_else(|| "unknown".into(), words);
        let fault_report = (state.fault_node, state.fault_code);
        if fault_report != self.fault_report && fault_report.1 != 0 {
            let about = self.name_of(fault_report.0);
            // The guard's emergency frame has the same code, but not the node.
            self.unnamed.retain(|(code, _)| *code != fault_report.1);
            if self.logged.insert(fault_report) {
                let words = fault_words(fault_report.1);
                let text = format!("guard: {words} of {}", self.words_for(fault_report.0));
                self.note(Level::Error, text);
            }
            self.notices.push(Notice {
                by: NodeName::GUARD,
                about,
                time_us,
            });
        }
        if fault_report != self.fault_report {
            self.logged.remove(&self.fault_report);
        }
        self.fault_report = fault_report;
    }

    /// Decodes the position. The world's x axis points north, its y axis west.
    fn receive_position(&mut self, position: GuardPosition) {
        let GuardPosition {
            north,
            east,
            up,
            validity,
            age,
        } = position;
        self.received.validity = [0, 2, 4, 6].map(|bit| validity >> bit & 3);
        let metres = |centimetres: i16| f64::from(centimetres) * 0.01;
        self.received.position =
            (self.received.validity[0] > 0).then(|| [metres(north), -metres(east), metres(up)]);
        self.received.fix_age = f64::from(age) * 0.1;
    }

    fn receive_emergency(&mut self, node: u8, code: u16, time_us: u64) {
        let name = self.words_for(node);
        if code == 0 {
            self.logged.retain(|(of, _)| *of != node);
            self.note(Level::Info, format!("{name}: all clear"));
        } else if node == self.guard() {
            if self.fault_report.1 != code {
                self.unnamed.push((code, 0));
            }
        } else if self.logged.insert((node, code)) {
            self.note(Level::Error, format!("{name}: {}", fault_words(code)));
        }
        if let Some(by) = self.name_of(node).filter(|_| code != 0) {
            self.notices.push(Notice {
                by,
                about: None,
                time_us,
            });
        }
    }
}

/// Converts an angle of 2^-16 turns to rad.
fn turn(binary: i16) -> f64 {
    f64::from(binary) / 65_536.0 * TAU
}

fn fault_words(code: u16) -> String {
    let name = Fault::from_code(code).map_or("unknown fault", |fault| fault.description().name);
    format!("{name} ({code:#06x})")
}

/// Describes a verdict in results and pages: the effect on the command, a colon, and the reason.
pub fn words(verdict: Verdict) -> String {
    let edge = |edge: Edge| match edge {
        Edge::Back => "backward margin",
        Edge::Front => "forward margin",
        Edge::Left => "left margin",
        Edge::Right => "right margin",
    };
    match verdict {
        Verdict::Passed => "passed".into(),
        Verdict::Scaled(by) => format!("scaled: {}", edge(by)),
        Verdict::Refused(by) => format!("refused: {}", edge(by)),
        Verdict::Blind(reason) => format!("refused: {}", reason.words()),
        Verdict::Unattended => "refused: no operator".into(),
        Verdict::PostureRefused(by) => format!("refused: posture, {}", edge(by)),
        Verdict::PostureScaled(by) => format!("scaled: posture, {}", edge(by)),
        Verdict::EmergencyStopped => "refused: emergency stop".into(),
        Verdict::Tripped(by) => format!("refused: tripped, {}", edge(by)),
        Verdict::Overridden(by) => format!("overridden: {}", edge(by)),
        Verdict::BackingOff(by) => format!("backing off: {}", edge(by)),
        Verdict::Doubted(reason) => format!("scaled: {}", reason.words()),
    }
}
