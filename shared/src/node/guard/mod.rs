//! The guard: master of the network, body controller of the robot it is built for ([`crate::robots::Body`]) and, above both,
//! the filter that passes a command on only as far as the margins allow.
//!
//! [`drives`] is what the guard knows of the other nodes, [`sequence`] the order in which they are brought to life,
//! this file the tick.

mod drives;
mod robot_state;
mod sequence;

pub use sequence::State;

use crate::bus::network::{NmtCommand, nmt, sync};
use crate::bus::pdo::{
    GuardMargins, GuardMotion, GuardPassed, GuardPosition, GuardState, OperatorCommand, Request,
};
use crate::can::Frame;
use crate::estimate::state::{Estimator, State as RobotState};
use crate::math::to_i16;
use crate::node::BodySensors;
use crate::robots::{Allowed, Asked, Body, MAX_DRIVES};
use crate::settings::{Setting, Settings};
use crate::stability::attitude::Attitude;
use crate::stability::filter::{self, Bounds, Margins, Tracker, Verdict};
use drives::Drives;
use heapless::Vec;
use sequence::Sequence;

/// Most frames that one tick sends: SYNC, network management, one set-point per drive.
pub const MAX_SENT: usize = MAX_DRIVES + 2;

/// Age of the newest attitude after which the guard no longer knows how the robot stands.
const ATTITUDE_TIMEOUT_US: u64 = 50_000;

/// What the guard sensed and heard since the tick before.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// Time since power-up, us.
    pub now_us: u64,
    /// Sensors on the body.
    pub body: Option<BodySensors>,
    /// Bytes of the satellite receiver.
    pub serial: &'a [u8],
    /// The operator's newest command, if one came.
    pub operator: Option<OperatorCommand>,
    /// Every frame that was received, in order.
    pub frames: &'a [Frame],
}

/// What the guard sends and tells.
#[derive(Clone, PartialEq, Debug)]
pub struct Outputs {
    /// Frames to send in this order: SYNC, network management, set-points.
    pub frames: Vec<Frame, MAX_SENT>,
    /// Payload of TPDO 1.
    pub motion: GuardMotion,
    /// Payload of TPDO 2.
    pub state: GuardState,
    /// Payload of TPDO 3.
    pub margins: GuardMargins,
    /// Payload of TPDO 4.
    pub passed: GuardPassed,
    /// The robot's state and payload of TPDO 5, in ticks that send SYNC.
    pub robot: Option<(RobotState, GuardPosition)>,
    /// Times that a command was refused (object 0x4005:1).
    pub refused: u32,
    /// Times that a command was scaled (object 0x4005:2).
    pub scaled: u32,
    /// Code of an emergency frame to send now; 0 is "all clear".
    pub emergency: Option<u16>,
}

/// A node's fault or loss that holds the robot.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Trouble {
    node: u8,
    code: u16,
}

/// State of the guard.
#[derive(Clone, Debug)]
pub struct Guard<B> {
    sync_period_us: u64,
    next_sync_us: u64,
    operator_timeout_us: u64,
    drives: Drives,
    sequence: Sequence,
    body: B,
    bounds: Bounds,
    filter_active: bool,
    tracker: Tracker,
    margins: Margins,
    share: f32,
    attitude: Attitude,
    attitude_us: Option<u64>,
    estimator: Estimator,
    operator: OperatorCommand,
    operator_us: Option<u64>,
    trouble: Option<Trouble>,
    verdict: Verdict,
    refused: u32,
    scaled: u32,
}

impl<B: Body> Guard<B> {
    /// Guard with these settings.
    ///
    /// # Errors
    /// The robot's, when the settings make none.
    pub fn new(settings: &Settings) -> Result<Self, B::Refusal> {
        let metres = |setting| settings.scaled(setting, 1e-6);
        Ok(Self {
            sync_period_us: settings.get(Setting::SyncPeriod) as u64,
            next_sync_us: 0,
            operator_timeout_us: settings.milliseconds(Setting::OperatorTimeout),
            drives: Drives::new(&B::drive_ids(settings), settings),
            sequence: Sequence::default(),
            body: B::new(settings)?,
            bounds: Bounds {
                caution: metres(Setting::CautionMargin),
                stop: metres(Setting::StopMargin),
                horizon: settings.scaled(Setting::PredictionHorizon, 1e-3),
            },
            filter_active: settings.get(Setting::FilterActive) == 1,
            tracker: Tracker::default(),
            margins: Margins::default(),
            share: 1.0,
            attitude: Attitude::default(),
            attitude_us: None,
            estimator: Estimator::new(settings),
            operator: OperatorCommand::default(),
            operator_us: None,
            trouble: None,
            verdict: Verdict::Passed,
            refused: 0,
            scaled: 0,
        })
    }

    /// One control period.
    pub fn tick(&mut self, inputs: &Inputs<'_>) -> Outputs {
        let trouble_before = self.trouble;
        if let Some(sensors) = &inputs.body
            && self.attitude.update(sensors, super::CONTROL_PERIOD)
        {
            self.attitude_us = Some(inputs.now_us);
            self.estimator
                .sense(sensors.magnetic_field, &mut self.attitude, inputs.now_us);
        }
        self.estimator.listen(inputs.serial, inputs.now_us);
        for frame in inputs.frames {
            self.drives.hear(frame, inputs.now_us);
        }
        self.listen(inputs);
        self.supervise(inputs.now_us);

        let (mut frames, mut robot) = (Vec::new(), None);
        if inputs.now_us >= self.next_sync_us {
            self.next_sync_us = inputs.now_us + self.sync_period_us;
            self.cycle(inputs.now_us, &mut frames);
            robot = Some(self.locate(inputs.now_us));
        }
        let emergency = (trouble_before != self.trouble)
            .then(|| self.trouble.map_or(0, |trouble| trouble.code));
        Outputs {
            robot,
            ..self.outputs(frames, emergency)
        }
    }

    /// Brings the robot's state up to date with the drives.
    fn locate(&mut self, now_us: u64) -> (RobotState, GuardPosition) {
        self.estimator.advance(
            self.body.odometry_um(),
            robot_state::odometry_us::<B>(self.drives.states()),
            self.body.joints(self.drives.states()),
            &self.attitude,
            now_us,
        );
        let state = self.estimator.state(&self.attitude, now_us);
        (state, robot_state::summary(&state))
    }

    /// Where the robot's position is counted from, and what became of the satellite receiver's sentences.
    pub fn estimator(&self) -> &Estimator {
        &self.estimator
    }

    /// Takes the operator's command; a changed sequence number shows that there is an operator.
    fn listen(&mut self, inputs: &Inputs<'_>) {
        let Some(command) = inputs.operator else {
            return;
        };
        let first = self.operator_us.is_none();
        if first || command.sequence != self.operator.sequence {
            self.operator_us = Some(inputs.now_us);
        }
        let before = Request::from_byte(self.operator.request);
        if Request::from_byte(command.request) == Request::Reset
            && (first || before != Request::Reset)
        {
            self.trouble = None;
            self.drives.reset_faults();
        }
        self.operator = command;
    }

    /// The first fault or loss latches until the operator's reset.
    fn supervise(&mut self, now_us: u64) {
        if self.trouble.is_none() && self.sequence.state() != State::Waiting {
            self.trouble = self.drives.trouble(now_us, self.sequence.driving());
        }
    }

    /// What happens once per SYNC: filter, body, sequence, set-points.
    fn cycle(&mut self, now_us: u64, frames: &mut Vec<Frame, MAX_SENT>) {
        // At most 100 ms.
        let period = self.sync_period_us as u32 as f32 * 1e-6;
        let request = Request::from_byte(self.operator.request);
        let started = self.sequence.advance(
            request,
            self.trouble.is_some(),
            &self.drives,
            &mut self.body,
            now_us,
        );
        if let Some(speed) = self.estimator.take_speed(&self.attitude) {
            self.body.hear_speed(speed, &self.attitude);
        }
        self.body
            .observe(self.drives.states(), &self.attitude, period);
        self.margins = self
            .tracker
            .update(&self.body.stance(&self.attitude), period);
        self.dispose(request, now_us, period);

        // Room for all of them: MAX_SENT.
        let _ = frames.push(sync());
        if started {
            let _ = frames.push(nmt(NmtCommand::Start, 0));
        }
        if self.sequence.state() != State::Waiting {
            let goal = |drive| self.sequence.goal(drive, &self.body);
            frames.extend(self.drives.commands(goal));
        }
    }

    /// Passes the operator's command on to the body, as far as the margins allow.
    fn dispose(&mut self, request: Request, now_us: u64, period: f32) {
        if self.sequence.state() != State::Armed {
            self.body.rest();
            self.share = 1.0;
            self.count(Verdict::Passed);
            return;
        }
        let fresh = |since: Option<u64>, timeout_us| {
            since.is_some_and(|heard| now_us.saturating_sub(heard) <= timeout_us)
        };
        let hindrance = if !fresh(self.attitude_us, ATTITUDE_TIMEOUT_US) {
            Some(Verdict::Blind)
        } else if !fresh(self.operator_us, self.operator_timeout_us) {
            Some(Verdict::Unattended)
        } else {
            None
        };
        let asked = if request == Request::Arm && hindrance.is_none() {
            Asked {
                forward: f32::from(self.operator.forward) * 1e-3,
                yaw_rate: f32::from(self.operator.yaw_rate) * 1e-3,
                posture: self.operator.posture,
            }
        } else {
            Asked {
                posture: self.body.posture(),
                ..Asked::default()
            }
        };
        let (allowed, filtered) = self.filter(&asked, period);
        self.share = allowed.share;
        self.body.advance(&asked, allowed, &self.attitude, period);
        self.count(hindrance.unwrap_or(filtered));
    }

    /// What the margins leave of `asked`. The horizon includes the time that a stop takes from the present speed.
    fn filter(&self, asked: &Asked, period: f32) -> (Allowed, Verdict) {
        let ahead = self
            .body
            .stance_ahead(asked, &self.attitude, self.bounds.horizon, period);
        let posture = filter::posture(&self.margins, ahead.margins(), &self.bounds);
        let bounds = Bounds {
            horizon: self.bounds.horizon + self.body.stopping_time(),
            ..self.bounds
        };
        let pitch = self.attitude.pitch().radians();
        let (share, drive) = filter::drive(asked.forward, pitch, &self.margins, &bounds);
        if !self.filter_active {
            let allowed = Allowed {
                share: 1.0,
                posture: true,
            };
            return (allowed, Verdict::Passed);
        }
        let allowed = Allowed {
            share,
            posture: posture == Verdict::Passed,
        };
        let verdict = if drive == Verdict::Passed {
            posture
        } else {
            drive
        };
        (allowed, verdict)
    }

    fn count(&mut self, verdict: Verdict) {
        let kind = |verdict: Verdict| verdict.code() >> 4;
        if kind(verdict) != kind(self.verdict) {
            match verdict {
                Verdict::Passed => {}
                Verdict::Scaled(_) => self.scaled = self.scaled.saturating_add(1),
                Verdict::Refused(_)
                | Verdict::PostureRefused(_)
                | Verdict::Blind
                | Verdict::Unattended => {
                    self.refused = self.refused.saturating_add(1);
                }
            }
        }
        self.verdict = verdict;
    }

    fn outputs(&self, frames: Vec<Frame, MAX_SENT>, emergency: Option<u16>) -> Outputs {
        let centidegrees = |radians: f32| to_i16(radians.to_degrees() * 100.0);
        let millimetres = |metres: f32| to_i16(metres * 1e3);
        let [back, front, left, right] = self.margins.now.map(millimetres);
        let trouble = self.trouble.unwrap_or(Trouble { node: 0, code: 0 });
        Outputs {
            frames,
            motion: GuardMotion {
                odometry: self.body.odometry_um(),
                pitch: centidegrees(self.attitude.pitch().radians()),
                roll: centidegrees(self.attitude.roll().radians()),
            },
            state: GuardState {
                state: self.sequence.state().code(),
                verdict: self.verdict.code(),
                scale: to_i16(self.share * 100.0) as u8,
                fault_node: trouble.node,
                fault_code: trouble.code,
                heading: (self.attitude.heading().to_bits() >> 16) as i16,
            },
            margins: GuardMargins {
                back,
                front,
                left,
                right,
            },
            passed: GuardPassed {
                asked_speed: self.operator.forward,
                passed_speed: millimetres(self.body.speed()),
                asked_posture: self.operator.posture,
                passed_posture: self.body.posture(),
            },
            robot: None,
            refused: self.refused,
            scaled: self.scaled,
            emergency,
        }
    }
}
