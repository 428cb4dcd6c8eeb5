//! A run whose operator may be a person. Every input takes effect at a step and is recorded, so
//! that the saved scenario is bit-identical with the run.

use crate::programs::Programs;
use crate::robots::Posture;
use crate::scenario::{
    Belts, Clearance, ClientFrame, Description, Event, Expect, Fault, FaultKind, Motion, Operator,
    OperatorRequest, Scenario, When,
};
use crate::simulator::record::Sample;
use crate::simulator::run::operator::PERIOD_US;
use crate::simulator::run::{Options, Run, RunError, Sink};
use crate::world::Plant;
use crate::world::terrain::Terrain;
use serde::{Deserialize, Serialize};
use std::time::Duration;
use tautrack::link::STEP_US;
use tautrack::node::guard::State;

/// Maximum virtual time of a run that a person drives, s: that of a scenario.
const MAXIMUM_S: f64 = 3_600.0;
/// Number of commands to stop that make the next request to arm a new one.
const STOPS: u8 = 4;

/// What the person commands: absolute values, which the guard limits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Command {
    /// Forward speed, m/s.
    pub speed_mps: f64,
    /// Yaw rate, counter-clockwise positive, degrees/s.
    pub yaw_rate_deg_s: f64,
    /// Chassis angle of B2P2, front up positive, degrees.
    pub chassis_deg: f64,
    /// Clearance of Hylos, m.
    pub clearance_m: f64,
    /// Height of the step ahead of RT-Mover, m; 0 commands no gait.
    pub step_m: f64,
    /// Whether the belts of B2P2 are released.
    pub released: bool,
    /// Whether B2P2 clears obstacles by itself.
    pub autonomous: bool,
}

impl Default for Command {
    fn default() -> Self {
        Self {
            speed_mps: 0.0,
            yaw_rate_deg_s: 0.0,
            chassis_deg: 0.0,
            clearance_m: 0.0,
            step_m: 0.0,
            released: false,
            autonomous: false,
        }
    }
}

impl Command {
    /// The command within the bounds of a scenario, and with as many digits as a file needs.
    fn within(self, posture: Posture) -> Self {
        let digits = |value: f64, one: f64| (value / one).round() * one;
        let whole = |value: f64, least: f64, most: f64, per: f64| {
            let value = if value.is_nan() { 0.0 } else { value };
            // The quotient of two whole numbers is the number nearest to its decimals.
            digits(value.clamp(least, most) * per, 1.0) / per
        };
        let mut within = Self {
            speed_mps: whole(self.speed_mps, -1.0, 1.0, 1e3),
            yaw_rate_deg_s: whole(self.yaw_rate_deg_s, -180.0, 180.0, 10.0),
            ..Self::default()
        };
        match posture {
            Posture::None => {}
            Posture::ChassisAngle { travel } => {
                let [least, most] = travel.map(f64::to_degrees);
                // Rounding must not leave the travel.
                let (least, most) = ((10.0 * least).ceil() / 10.0, (10.0 * most).floor() / 10.0);
                within.chassis_deg = whole(self.chassis_deg, least, most, 10.0);
                within.released = self.released;
                within.autonomous = self.autonomous;
            }
            Posture::Clearance { .. } => {
                within.clearance_m = whole(self.clearance_m, 0.1, 0.4, 1e3);
            }
            Posture::Step => within.step_m = whole(self.step_m, 0.0, 0.3, 1e3),
        }
        within
    }

    /// The event that changes the command from `before` to this one at a time.
    fn since(&self, before: &Self, time_s: f64) -> Event {
        let changed = |now: f64, before: f64| (now != before).then_some(now);
        Event {
            when: When {
                time_s: Some(time_s),
                ..When::default()
            },
            chassis_deg: changed(self.chassis_deg, before.chassis_deg),
            step_m: changed(self.step_m, before.step_m),
            clearance_m: changed(self.clearance_m, before.clearance_m),
            speed_mps: changed(self.speed_mps, before.speed_mps),
            yaw_rate_deg_s: changed(self.yaw_rate_deg_s, before.yaw_rate_deg_s),
            belts: (self.released != before.released).then_some(if self.released {
                Belts::Released
            } else {
                Belts::Taut
            }),
            clearance: (self.autonomous != before.autonomous).then_some(if self.autonomous {
                Clearance::Autonomous
            } else {
                Clearance::Manual
            }),
            request: None,
        }
    }
}

/// A run with its inputs.
pub struct Drive {
    run: Run,
    /// What has been run: the scenario with the inputs until now.
    recorded: Description,
    steps: u64,
    person: bool,
    posture: Posture,
    wanted: Command,
    commanded: Command,
    /// Whether an emergency stop waits for the operator's next command.
    emergency: bool,
    /// Request that waits for the operator's next command, or the one after an emergency stop.
    asked: Option<OperatorRequest>,
    requested: OperatorRequest,
    /// Number of commands for which the request is still kept before a request to arm: the guard
    /// takes one that persists.
    kept: u8,
    /// Number of commands to stop that the guard has received while it was ready.
    stops: u8,
    /// The request to arm that is to be sent when the guard takes it.
    arms: Option<OperatorRequest>,
}

impl Drive {
    /// Starts the run of a scenario. With a `person` as the operator, the scenario's operator is
    /// left out.
    ///
    /// # Errors
    /// A text: a node does not start, or the scenario is not valid.
    pub fn start(scenario: &Scenario, person: bool) -> Result<Self, String> {
        let mut recorded = scenario.description();
        if person {
            recorded.operator = Operator::person();
            recorded.duration_s = MAXIMUM_S;
            recorded.expect = Expect::default();
        }
        let scenario = Scenario::checked(recorded.clone()).map_err(|error| error.to_string())?;
        let programs = Programs::in_process(scenario.kind().facts().guard_program);
        let run = Run::start(&scenario, &programs, Options::default());
        let posture = scenario.robot.section().posture();
        let command = Command {
            clearance_m: match posture {
                Posture::Clearance { first_m } => first_m,
                _ => 0.0,
            },
            ..Command::default()
        };
        Ok(Self {
            run: run.map_err(|error| error.to_string())?,
            recorded,
            steps: 0,
            person,
            posture,
            wanted: command,
            commanded: command,
            emergency: false,
            asked: None,
            requested: OperatorRequest::Stop,
            kept: 0,
            stops: 0,
            arms: None,
        })
    }

    /// Number of steps done.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The scenario with the inputs until now.
    pub fn recorded(&self) -> &Description {
        &self.recorded
    }

    /// The simulated robot on its ground.
    pub fn plant(&self) -> &dyn Plant {
        self.run.plant()
    }

    /// Whether each node has power, in the robot's order.
    pub fn powered(&self) -> Vec<bool> {
        self.run.powered().collect()
    }

    /// The command that the operator sends.
    pub fn commanded(&self) -> &Command {
        &self.commanded
    }

    /// The request that the operator sends.
    pub fn requested(&self) -> OperatorRequest {
        self.requested
    }

    /// Returns the sample of the last step. Each event is in one sample.
    pub fn sample(&mut self) -> Sample {
        self.run.sample(self.steps)
    }

    /// Commands this from the operator's next command on.
    pub fn command(&mut self, command: Command) {
        self.wanted = command.within(self.posture);
    }

    /// Requests this from the operator's next command on. A request to arm is sent when the guard
    /// takes it. An emergency stop is sent, whatever is requested after it.
    pub fn request(&mut self, request: OperatorRequest) {
        match request {
            OperatorRequest::Arm | OperatorRequest::ArmOffLevel => self.arms = Some(request),
            OperatorRequest::EmergencyStop => {
                (self.arms, self.asked, self.emergency) = (None, None, true);
            }
            _ => (self.arms, self.asked) = (None, Some(request)),
        }
    }

    /// Lets a fault begin with the next step.
    ///
    /// # Errors
    /// A text: the fault is not valid for this robot.
    pub fn break_it(&mut self, what: FaultKind) -> Result<(), String> {
        let fault = Fault {
            what,
            at_s: seconds(self.steps + 1),
            until_s: None,
            notice_within_ms: None,
        };
        let mut tried = self.recorded.clone();
        tried.faults.push(fault.clone());
        tried.check().map_err(|problem| problem.to_string())?;
        self.recorded.faults.push(fault.clone());
        self.run.add_fault(fault);
        Ok(())
    }

    /// Lets all faults like this one end with the next step.
    pub fn mend(&mut self, what: &FaultKind) {
        let until_s = seconds(self.steps + 1);
        for (index, fault) in self.recorded.faults.iter_mut().enumerate() {
            if fault.what == *what && fault.until_s.is_none() {
                fault.until_s = Some(until_s);
                self.run.end_fault(index, until_s);
            }
        }
    }

    /// The faults that have been let begin and have not been let end.
    pub fn active_faults(&self) -> Vec<&FaultKind> {
        let faults = self.recorded.faults.iter();
        let active = faults.filter(|fault| fault.until_s.is_none());
        active.map(|fault| &fault.what).collect()
    }

    /// Sends a frame from a client in the next step.
    ///
    /// # Errors
    /// A text: it is no frame.
    pub fn send(&mut self, id: u16, data: Vec<u8>) -> Result<(), String> {
        let at_ms = self.steps + 1;
        let frame = ClientFrame { at_ms, id, data };
        frame.frame().ok_or("no CAN frame")?;
        let frames = &mut self.recorded.frames;
        let place = frames.partition_point(|of| of.at_ms <= at_ms);
        frames.insert(place, frame.clone());
        self.run.add_frame(frame);
        Ok(())
    }

    /// Runs one millisecond.
    ///
    /// # Errors
    /// [`RunError`]. After one the run has ended.
    pub fn step(&mut self, sink: &mut dyn Sink) -> Result<(), RunError> {
        let step = self.steps + 1;
        if self.person && (step * STEP_US).is_multiple_of(PERIOD_US) {
            self.operate(seconds(step));
        }
        self.run.step(step, sink)?;
        self.steps = step;
        Ok(())
    }

    /// Adds the event that brings the command to what is wanted.
    fn operate(&mut self, time_s: f64) {
        let request = self.next_request();
        let mut event = self.wanted.since(&self.commanded, time_s);
        event.request = (request != self.requested).then_some(request);
        self.commanded = self.wanted;
        self.requested = request;
        if event.changes_nothing() {
            return;
        }
        self.run.add_event(event.clone());
        self.recorded.operator.events.push(event);
    }

    /// The request of the next command. An armed guard takes a request to arm as one to go on; a
    /// guard that is not takes one that follows requests to stop.
    fn next_request(&mut self) -> OperatorRequest {
        let emergency = std::mem::take(&mut self.emergency);
        let emergency = emergency.then_some(OperatorRequest::EmergencyStop);
        if let Some(asked) = emergency.or_else(|| self.asked.take()) {
            (self.stops, self.kept) = (0, STOPS);
            // The guard takes a request to reset once, when the request changes to it.
            if (asked, self.requested) == (OperatorRequest::Reset, OperatorRequest::Reset) {
                self.asked = Some(asked);
                return OperatorRequest::Stop;
            }
            return asked;
        }
        if self.kept > 0 {
            self.kept -= 1;
            return self.requested;
        }
        let Some(arm) = self.arms else {
            return self.requested;
        };
        let state = self.run.view().state;
        // Who puts a robot on a slope knows that it is not level.
        let arm = match self.recorded.terrain {
            Terrain::Slope { .. } => OperatorRequest::ArmOffLevel,
            _ => arm,
        };
        if self.requested == OperatorRequest::Stop && state == Some(State::Ready) {
            self.stops += 1;
        }
        if state == Some(State::Armed) || self.stops >= STOPS {
            (self.arms, self.stops) = (None, 0);
            return arm;
        }
        OperatorRequest::Stop
    }

    /// Returns the scenario that repeats the run until now, as the text of a file. It expects no
    /// results, and leaves out what is not due until now.
    ///
    /// # Errors
    /// A text, if no scenario is as short as the run, or it cannot be written.
    pub fn save(&self) -> Result<String, String> {
        let mut description = self.recorded.clone();
        // Half a step more: the number of whole steps is that of the run.
        let end_s = ((self.steps as f64 + 0.5) / 1e3).min(MAXIMUM_S);
        description.duration_s = end_s;
        description.expect = Expect::default();
        description.operator.events.truncate(self.run.events_done());
        description.faults.retain(|fault| fault.at_s <= end_s);
        for fault in &mut description.faults {
            fault.notice_within_ms = None;
        }
        description.frames.retain(|frame| frame.at_ms <= self.steps);
        cut(&mut description.hand, end_s);
        if let Some(payload) = description.robot.payload_mut() {
            payload.from_s = payload.from_s.min(end_s);
        }
        let scenario = Scenario::checked(description).map_err(|error| error.to_string())?;
        toml::to_string(&scenario).map_err(|error| error.to_string())
    }

    /// Hash of the run until now, as in `summary.json`.
    pub fn hash(&self) -> String {
        self.run.facts(Duration::ZERO, self.steps).state_hash
    }
}

/// Virtual time of a step, s; the operator's view and the faults compute it equally.
fn seconds(step: u64) -> f64 {
    (step * STEP_US) as f64 * 1e-6
}

/// Leaves out the motions of the hand that have not begun at this time. Between two motions the
/// hand holds the robot; so that it does not let go, the second one begins then.
fn cut(hand: &mut Vec<Motion>, end_s: f64) {
    let begun = hand.partition_point(|motion| motion.at_s <= end_s);
    let last = hand[..begun].last();
    let ended = last.is_some_and(|last| last.at_s + last.within_s <= end_s);
    hand.truncate(begun + usize::from(ended));
    if let Some(next) = hand.get_mut(begun) {
        next.at_s = end_s;
    }
}
