//! Operator of a run: a participant of the bus that uses only the guard's public objects.

use super::listener::View;
use crate::robots::Posture;
use crate::scenario::{Ask, Belts, BusView, Clearance, Event, OperatorRequest, Scenario, Script};
use crate::world::terrain::Terrain;
use std::f64::consts::TAU;
use tautrack::bus::pdo::{BELTS_RELEASED, CLEARANCE, OperatorCommand, Payload, Request, receive};
use tautrack::can::Frame;
use tautrack::node::guard::State;

/// Time between two commands, us.
pub const PERIOD_US: u64 = 20_000;

/// Number of requests to stop after which a request to arm counts as a new one.
const STOPS: u8 = 3;

/// Plays the script of a scenario, starting when the guard is armed, or at power-up.
pub struct Operator {
    scenario: crate::scenario::Operator,
    script: Option<Script>,
    let_go_us: Option<u64>,
    disarm_us: Option<u64>,
    /// Request with which the robot is armed.
    arms: Request,
    commands_us: Vec<u64>,
    theta: f64,
    sequence: u8,
    /// Number of stop requests that were sent while the guard was ready, up to [`STOPS`].
    stops: u8,
    /// Whether the request is to arm; it stays so from then on.
    asks_to_arm: bool,
    guard: u8,
    posture: Posture,
}

impl Operator {
    /// Creates the operator of this scenario, who commands the guard with node id `guard` and arms
    /// it as soon as it is ready. From `let_go_s` on, no motion is commanded; from `disarm_s` on,
    /// the request is to disarm. Sends nothing if a client is the operator.
    pub fn new(
        scenario: &Scenario,
        guard: u8,
        let_go_s: Option<f64>,
        disarm_s: Option<f64>,
    ) -> Self {
        let microseconds = |time_s: f64| (time_s * 1e6) as u64;
        Self {
            scenario: scenario.operator.clone(),
            script: None,
            let_go_us: let_go_s.map(microseconds),
            disarm_us: disarm_s.map(microseconds),
            arms: match (scenario.operator.request, &scenario.terrain) {
                (Some(request), _) => request.code(),
                (None, Terrain::Slope { .. }) => Request::ArmOffLevel,
                (None, _) => Request::Arm,
            },
            commands_us: Vec::new(),
            theta: 0.0,
            sequence: 0,
            stops: 0,
            asks_to_arm: false,
            guard,
            posture: scenario.robot.section().posture(),
        }
    }

    /// Times at which the script changed the command, including its start, us.
    pub fn commands_us(&self) -> &[u64] {
        &self.commands_us
    }

    /// Number of events of the script that have taken effect.
    pub fn events_done(&self) -> usize {
        self.script.as_ref().map_or(0, Script::events_done)
    }

    /// Adds an event to the script.
    pub fn add(&mut self, event: Event) {
        if let Some(script) = &mut self.script {
            script.add(event.clone());
        }
        self.scenario.events.push(event);
    }

    /// Returns the command to send at this time, if one is due.
    pub fn tick(&mut self, time_us: u64, view: &View) -> Option<Frame> {
        if self.scenario.client || !time_us.is_multiple_of(PERIOD_US) {
            return None;
        }
        let now = BusView {
            time_s: time_us as f64 * 1e-6,
            ..view.bus
        };
        let begins = self.scenario.from_power_up || view.state == Some(State::Armed);
        if begins && self.script.is_none() {
            self.script = Some(Script::new(&self.scenario, now, view.passed_theta));
            self.commands_us.push(time_us);
        }
        self.sequence = self.sequence.wrapping_add(1);
        if view.state == Some(State::Ready) {
            self.asks_to_arm |= self.stops == STOPS;
            self.stops = (self.stops + 1).min(STOPS);
        }
        let mut command = OperatorCommand {
            request: if self.asks_to_arm {
                self.arms
            } else {
                Request::Stop
            } as u8,
            sequence: self.sequence,
            ..OperatorCommand::default()
        };
        if let Some(script) = &mut self.script {
            let events = script.events_done();
            let ask = script.tick(now);
            if script.events_done() > events {
                self.commands_us.push(time_us);
            }
            let belts = match ask.belts {
                Belts::Taut => 0,
                Belts::Released => BELTS_RELEASED,
            };
            let clearance = match ask.clearance {
                Clearance::Manual => 0,
                Clearance::Autonomous => CLEARANCE,
            };
            command.request = ask.request.code() as u8 | belts | clearance;
            let let_go = self.let_go_us.is_some_and(|since| time_us >= since);
            if !let_go {
                self.theta = ask.theta;
            }
            let ask = if let_go {
                Ask {
                    speed_mps: 0.0,
                    yaw_rate: 0.0,
                    theta: self.theta,
                    step_m: 0.0,
                    ..ask
                }
            } else {
                ask
            };
            let milli = |value: f64| (value * 1e3).round() as i16;
            command.forward = milli(ask.speed_mps);
            command.yaw_rate = milli(ask.yaw_rate);
            command.posture = match self.posture {
                Posture::None => 0,
                Posture::ChassisAngle { .. } => (ask.theta / TAU * 65_536.0).round() as i16,
                Posture::Clearance { first_m } => milli(ask.clearance_m.unwrap_or(first_m)),
                Posture::Step => milli(ask.step_m),
            };
        }
        if self.disarm_us.is_some_and(|since| time_us >= since) {
            command.request = OperatorRequest::Disarm.code() as u8;
        }
        Some(command.frame(receive(1), self.guard))
    }
}
