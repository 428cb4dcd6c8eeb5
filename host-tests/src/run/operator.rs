//! The operator: one more participant of the bus, who sees and uses nothing but the guard's public objects.

use super::listener::View;
use crate::machines::Kind;
use crate::scenario::{Ask, BusView, Scenario, Script};
use std::f64::consts::TAU;
use tautrack::bus::pdo::{OperatorCommand, Payload, Request, receive};
use tautrack::can::Frame;
use tautrack::node::guard::State;

/// Time between two commands, us.
pub const PERIOD_US: u64 = 20_000;

/// Plays a scenario's script from the moment at which the guard is armed.
pub struct Operator {
    scenario: crate::scenario::Operator,
    script: Option<Script>,
    let_go_us: Option<u64>,
    theta: f64,
    sequence: u8,
    guard: u8,
    /// What is asked of a robot whose posture the script does not change.
    posture: Option<i16>,
    kind: Kind,
}

impl Operator {
    /// The operator of this scenario. He commands the guard with this id, arms it as soon as it is ready,
    /// and from `let_go_s` on commands nothing any more. Sends nothing where a client is the operator.
    pub fn new(scenario: &Scenario, guard: u8, let_go_s: Option<f64>) -> Self {
        Self {
            scenario: scenario.operator.clone(),
            script: None,
            let_go_us: let_go_s.map(|time_s| (time_s * 1e6) as u64),
            theta: 0.0,
            sequence: 0,
            guard,
            posture: scenario
                .hylos
                .as_ref()
                .map(|robot| (robot.clearance_m * 1e3).round() as i16),
            kind: scenario.kind(),
        }
    }

    /// The command to send at this time, if one is due.
    pub fn tick(&mut self, time_us: u64, view: &View) -> Option<Frame> {
        if self.scenario.client || !time_us.is_multiple_of(PERIOD_US) {
            return None;
        }
        let now = BusView {
            time_s: time_us as f64 * 1e-6,
            ..view.bus
        };
        if view.state == Some(State::Armed) && self.script.is_none() {
            self.script = Some(Script::new(&self.scenario, now, view.passed_theta));
        }
        self.sequence = self.sequence.wrapping_add(1);
        let mut command = OperatorCommand {
            request: if view.state.is_some_and(|state| state != State::Waiting) {
                Request::Arm
            } else {
                Request::Disarm
            } as u8,
            sequence: self.sequence,
            ..OperatorCommand::default()
        };
        if let Some(script) = &mut self.script {
            let ask = script.tick(now);
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
                }
            } else {
                ask
            };
            let milli = |value: f64| (value * 1e3).round() as i16;
            command.forward = milli(ask.speed_mps);
            command.yaw_rate = milli(ask.yaw_rate);
            command.posture = match self.posture {
                Some(posture) => posture,
                None if self.kind == Kind::RtMover => milli(ask.step_m),
                None => (ask.theta / TAU * 65_536.0).round() as i16,
            };
        }
        Some(command.frame(receive(1), self.guard))
    }
}
