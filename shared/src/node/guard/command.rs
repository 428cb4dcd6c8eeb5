//! Passes the operator's command to the body, as far as supervision and filter allow.

use super::interface::Inputs;
use super::supervision::Moment;
use super::{Guard, State};
use crate::bus::pdo::Request;
use crate::robots::{Asked, Body, PostureCommand};
use crate::stability::trip::Requests;
use crate::stability::verdict::Verdict;

impl<B: Body> Guard<B> {
    /// Passes the operator's command to the body, as far as supervision and margins allow.
    pub(super) fn pass_command(&mut self, inputs: &Inputs<'_>) {
        let (now_us, period) = (inputs.now_us, self.schedule.period());
        let request = self.operator.request();
        let present = self.operator.present(now_us);
        let seen = core::mem::take(&mut self.requests);
        let armed = self.state == State::Armed;
        let moment = Moment {
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
        let command = self.operator.command();
        let asked = Asked {
            forward: f32::from(command.forward) * 1e-3,
            yaw_rate: f32::from(command.yaw_rate) * 1e-3,
            posture: B::Posture::from_word(command.posture),
        };
        let (posture, speed) = (self.body.posture(), self.body.speed());
        let (asked, admitted) = self.supervision.admit(asked, posture, speed, &moment);
        let ahead =
            self.body
                .stance_ahead(&asked, &self.attitude, self.supervision.horizon(), period);
        let pitch = self.attitude.pitch().radians();
        let (allowed, filtered) =
            self.supervision
                .filter(&asked, ahead.as_ref(), pitch, self.body.stopping_time());
        if !armed {
            self.speed_scale = 1.0;
            // Only an emergency stop trips a robot that is not armed.
            self.tally.count(match admitted {
                Verdict::EmergencyStopped => admitted,
                _ => Verdict::Passed,
            });
            return;
        }
        let asked = Asked {
            yaw_rate: allowed.limits.yaw_rate(asked.yaw_rate, speed),
            ..asked
        };
        self.speed_scale = allowed.speed_scale;
        self.body.advance(&asked, allowed, &self.attitude, period);
        self.tally.count(match (admitted, filtered) {
            // If the filter refuses the way back, this is the reason why the robot stands.
            (Verdict::Passed, _) | (Verdict::BackingOff(_), Verdict::Refused(_)) => filtered,
            _ => admitted,
        });
    }
}
