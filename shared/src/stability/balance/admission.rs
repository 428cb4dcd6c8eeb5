//! Decides what may be commanded at all, from the trip, the trust in the sensors, and the operator.

use super::Balance;
use crate::sensing::Sensing;
use crate::sensing::trust::Trust;
use crate::stability::allowed::{Command, Stop};
use crate::stability::filter::Verdict;
use crate::stability::support::narrowest;
use crate::stability::trip::{self, Cause, Mode, Requests, Snapshot, crawl};

/// Time, operator and requests of one SYNC period.
#[derive(Clone, Copy, Debug)]
pub struct Inputs {
    /// Time since power-up, us.
    pub now_us: u64,
    /// Whether the guard is armed.
    pub armed: bool,
    /// The operator is present, and holds the dead-man switch if the settings require one.
    pub attended: bool,
    /// The operator requests ordinary driving.
    pub drives: bool,
    /// Requests to a tripped guard.
    pub requests: Requests,
    /// Distance travelled by the encoders, um; wraps.
    pub odometry_um: i32,
}

impl Balance {
    /// Returns the command that the body may get, and the verdict on it. It is the operator's
    /// command if an operator attends, the sensors are believed and no trip prevents it. Otherwise
    /// the robot stops, crawls or backs off.
    pub fn admit<P: Copy>(
        &mut self,
        command: Command<P>,
        posture: P,
        speed: f32,
        sensing: &Sensing,
        inputs: &Inputs,
    ) -> (Command<P>, Verdict) {
        let trust = self.trust;
        let latch = trip::Inputs {
            armed: inputs.armed && self.filter_active,
            band: self.bands.band(),
            trust,
            odometry_um: inputs.odometry_um,
            snapshot: Snapshot {
                cause: Cause::EmergencyStop,
                time_us: inputs.now_us,
                margins: self.margins.now,
                edge: narrowest(&self.margins.now),
                command: command.speeds(),
                speed,
                sensors: *sensing.body(),
            },
        };
        self.mode = self.trip.update(&latch, inputs.requests, &self.parameters);
        let edge = self
            .trip
            .snapshot()
            .map_or(latch.snapshot.edge, |kept| kept.edge);
        let cause = self.trip.snapshot().map(|kept| kept.cause);
        let stay = Command::default().with_posture(posture);
        let admitted = self.mode.admit(command.speeds(), &self.parameters);
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
            _ if !inputs.attended => (gently, Verdict::Unattended),
            (Mode::Overridden, _) => (
                (admitted.with_posture(command.posture), None),
                Verdict::Overridden(edge),
            ),
            (Mode::BackingOff(_), _) => (
                (admitted.with_posture(posture), None),
                Verdict::BackingOff(edge),
            ),
            _ if !inputs.drives => (gently, Verdict::Passed),
            (_, Trust::Degraded(reason)) if self.filter_active => {
                let slow = crawl(command.speeds(), &self.parameters);
                let verdict = if slow == command.speeds() {
                    Verdict::Passed
                } else {
                    Verdict::Doubted(reason)
                };
                ((slow.with_posture(command.posture), None), verdict)
            }
            _ => ((command, None), Verdict::Passed),
        };
        let (admitted, stop) = passed;
        self.stop = stop;
        (admitted, verdict)
    }
}
