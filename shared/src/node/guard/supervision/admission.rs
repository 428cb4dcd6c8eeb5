//! Decides what may be commanded at all, from the trip, the trust in the sensors, and the operator.

use super::Supervision;
use crate::robots::{Asked, Stop};
use crate::stability::filter::{SpeedCommand, Verdict};
use crate::stability::support::narrowest;
use crate::stability::trip::{Cause, Mode, Requests, Sight, Snapshot, crawl};
use crate::stability::trust::Trust;

/// Time, operator and requests of one SYNC period.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    pub now_us: u64,
    pub armed: bool,
    /// The operator is present, and holds the dead-man switch if the settings require one.
    pub attended: bool,
    /// The operator requests ordinary driving.
    pub drives: bool,
    pub requests: Requests,
    /// Distance travelled by the encoders, um; wraps.
    pub odometry_um: i32,
}

impl Supervision {
    /// Returns the command that the body may get, and the verdict on it. It is the operator's
    /// command if an operator attends, the sensors are believed and no trip prevents it. Otherwise
    /// the robot stops, crawls or backs off.
    pub fn admit<P: Copy>(
        &mut self,
        asked: Asked<P>,
        posture: P,
        speed: f32,
        moment: &Moment,
    ) -> (Asked<P>, Verdict) {
        let trust = self.trust;
        let command = SpeedCommand {
            forward: asked.forward,
            yaw_rate: asked.yaw_rate,
        };
        let sight = Sight {
            armed: moment.armed && self.filter_active,
            band: self.bands.band(),
            trust,
            odometry_um: moment.odometry_um,
            moment: Snapshot {
                cause: Cause::EmergencyStop,
                time_us: moment.now_us,
                margins: self.margins.now,
                edge: narrowest(&self.margins.now),
                asked: command,
                speed,
                sensors: self.sensors,
            },
        };
        self.mode = self.trip.update(&sight, moment.requests, &self.parameters);
        let edge = self
            .trip
            .snapshot()
            .map_or(sight.moment.edge, |kept| kept.edge);
        let cause = self.trip.snapshot().map(|kept| kept.cause);
        let stay = Asked {
            forward: 0.0,
            yaw_rate: 0.0,
            posture,
        };
        let with = |command: SpeedCommand, posture| Asked {
            forward: command.forward,
            yaw_rate: command.yaw_rate,
            posture,
        };
        let admitted = self.mode.admit(command, &self.parameters);
        let gently = (stay, Some(Stop::Gentle));
        let (passed, verdict) = match (self.mode, trust) {
            (Mode::Tripped, _) => {
                let verdict = match (cause, trust) {
                    (Some(Cause::EmergencyStop), _) => Verdict::EmergencyStopped,
                    (_, Trust::None(reason)) | (Some(Cause::Sensors(reason)), _) => {
                        Verdict::Blind(reason)
                    }
                    _ => Verdict::Tripped(edge),
                };
                ((stay, Some(Stop::Hard)), verdict)
            }
            (mode, Trust::None(reason)) if mode != Mode::Overridden => {
                (gently, Verdict::Blind(reason))
            }
            _ if !moment.attended => (gently, Verdict::Unattended),
            (Mode::Overridden, _) => (
                (with(admitted, asked.posture), None),
                Verdict::Overridden(edge),
            ),
            (Mode::BackingOff(_), _) => {
                ((with(admitted, posture), None), Verdict::BackingOff(edge))
            }
            _ if !moment.drives => (gently, Verdict::Passed),
            (_, Trust::Degraded(reason)) if self.filter_active => {
                let slow = crawl(command, &self.parameters);
                let verdict = if slow == command {
                    Verdict::Passed
                } else {
                    Verdict::Doubted(reason)
                };
                ((with(slow, asked.posture), None), verdict)
            }
            _ => ((asked, None), Verdict::Passed),
        };
        let (asked, stop) = passed;
        self.stop = stop;
        (asked, verdict)
    }
}
