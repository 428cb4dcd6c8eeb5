//! Takes the operator's command, and passes it to the body as far as the balance allows.

use super::interface::{FaultReport, Inputs};
use super::operator::Event;
use super::{Guard, State};
use crate::bus::pdo::Request;
use crate::bus::scale::from_milli;
use crate::faults::Fault;
use crate::robots::{Autonomy, Body, Command};
use crate::stability::balance;
use crate::stability::trip::Requests;
use crate::stability::verdict::Verdict;

impl<B: Body> Guard<B> {
    /// Takes the operator's command. A request that has changed to "reset" acknowledges everything.
    pub(super) fn listen(&mut self, inputs: &Inputs<'_>) {
        self.requests.emergency_stop |= inputs.emergency_stop;
        let Some(command) = inputs.operator else {
            return;
        };
        let event = self.operator.receive(command, inputs.now_us);
        self.requests.emergency_stop |= self.operator.request() == Request::EmergencyStop;
        match event {
            Some(Event::Reset) => {
                self.requests.reset = true;
                self.fault = None;
                self.drives.begin_reset();
                self.body.acknowledge();
            }
            Some(Event::TwoOperators) if self.fault.is_none() => {
                self.fault = Some(FaultReport {
                    node: self.drives.own_id(),
                    code: Fault::TwoOperators.code(),
                });
            }
            _ => {}
        }
    }

    /// Passes the operator's command to the body, as far as the margins allow.
    pub(super) fn pass_command(&mut self, inputs: &Inputs<'_>) {
        let (now_us, period) = (inputs.now_us, self.schedule.period());
        let request = self.operator.request();
        let present = self.operator.present(now_us);
        let seen = core::mem::take(&mut self.requests);
        let armed = self.state == State::Armed;
        let inputs = balance::Inputs {
            now_us,
            armed,
            attended: self.operator.attends(now_us),
            drives: self.operator.drives(now_us),
            requests: Requests {
                override_trip: request == Request::Override && present,
                back_off: request == Request::BackOff && present,
                // These count however short they were since the previous SYNC.
                reset: seen.reset,
                emergency_stop: seen.emergency_stop || request == Request::EmergencyStop,
            },
            odometry_um: self.body.odometry_um(),
        };
        let received = self.operator.command();
        let command = Command {
            forward: from_milli(received.forward),
            yaw_rate: from_milli(received.yaw_rate),
            posture: self
                .body
                .commanded_posture(received.posture, self.operator.releases_belts()),
        };
        let autonomy = match self.state {
            _ if !self.operator.lets_clear() => Autonomy::Off,
            State::Held => Autonomy::Stopped,
            State::Armed if self.balance.tripped() => Autonomy::Stopped,
            State::Armed if inputs.drives && inputs.attended => Autonomy::On,
            State::Armed => Autonomy::Waits,
            _ => Autonomy::Off,
        };
        let command = self.body.clear(command, autonomy, &self.attitude, period);
        let (posture, speed) = (self.body.posture(), self.body.speed());
        let (command, admitted) =
            self.balance
                .admit(command, posture, speed, &self.sensing, &inputs);
        let ahead =
            self.body
                .stance_ahead(&command, &self.attitude, self.balance.horizon(), period);
        let motion = balance::Motion {
            pitch: self.attitude.pitch().radians(),
            stopping: self.body.stopping_time(),
            forward_scale: self.body.forward_scale(&self.attitude),
        };
        let (allowed, filtered) = self.balance.filter(&command, ahead.as_ref(), motion);
        if !armed {
            self.speed_scale = 1.0;
            // Only an emergency stop trips a robot that is not armed.
            self.tally.count(match admitted {
                Verdict::EmergencyStopped => admitted,
                _ => Verdict::Passed,
            });
            return;
        }
        let command = Command {
            yaw_rate: allowed.limits.yaw_rate(command.yaw_rate, speed),
            ..command
        };
        self.speed_scale = allowed.speed_scale;
        self.body.advance(&command, allowed, &self.attitude, period);
        self.tally.count(match (admitted, filtered) {
            // If the filter refuses the way back, this is the reason why the robot stands.
            (Verdict::Passed, _) | (Verdict::BackingOff(_), Verdict::Refused(_)) => filtered,
            _ => admitted,
        });
    }
}
