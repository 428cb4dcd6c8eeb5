//! The guard: master of the network, body controller of the robot it is built for ([`crate::robots::Body`]) and, above both,
//! the filter that passes a command on only as far as the margins allow.
//!
//! [`drives`] is what the guard knows of the other nodes, [`sequence`] the order in which they are brought to life,
//! [`supervision`] what it knows of the robot's balance, this file the tick.

mod drives;
mod robot_state;
mod sequence;
mod supervision;

pub use sequence::State;
pub use supervision::Telemetry;

use crate::bus::network::{NmtCommand, nmt, sync};
use crate::bus::pdo::{
    DEAD_MAN_HELD, GuardMargins, GuardMotion, GuardPassed, GuardPosition, GuardState,
    OperatorCommand, Request,
};
use crate::can::Frame;
use crate::estimate::state::{Estimator, State as RobotState};
use crate::math::to_i16;
use crate::node::BodySensors;
use crate::robots::{Asked, Body, MAX_DRIVES};
use crate::settings::{Setting, Settings};
use crate::stability::attitude::Attitude;
use crate::stability::filter::Verdict;
use crate::stability::parameters::Refusal;
use crate::stability::trip::Requests;
use drives::Drives;
use heapless::Vec;
use sequence::Sequence;
use supervision::{Moment, Supervision};

/// Most frames that one tick sends: SYNC, network management, one set-point per drive.
pub const MAX_SENT: usize = MAX_DRIVES + 2;

/// SYNCs from one torque in advance to the next: such torques change slowly. They are sent in the last quarter of a period, in a
/// tick that has little else to do; with SYNC in every tick there is none.
pub const OFFSET_SYNCS: u32 = 4;

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
    /// The emergency stop is actuated, whoever did it.
    pub emergency_stop: bool,
    /// Every frame that was received, in order.
    pub frames: &'a [Frame],
}

/// What the guard sends and tells.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Outputs {
    /// Frames to send in this order: SYNC, network management, set-points; or torques in advance.
    pub frames: Vec<Frame, MAX_SENT>,
    /// Payload of TPDO 1.
    pub motion: GuardMotion,
    /// Payload of TPDO 2.
    pub state: GuardState,
    /// Payload of TPDO 3.
    pub margins: GuardMargins,
    /// Payload of TPDO 4.
    pub passed: GuardPassed,
    /// The robot's state and payload of TPDO 5, once in a SYNC period.
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
#[allow(clippy::struct_excessive_bools)] // two settings and what is still due in this period
pub struct Guard<B> {
    sync_period_us: u64,
    next_sync_us: u64,
    judged: bool,
    located: bool,
    syncs: u32,
    offsets_due: bool,
    operator_timeout_us: u64,
    drives: Drives,
    sequence: Sequence,
    body: B,
    supervision: Supervision,
    dead_man: bool,
    refusal: Option<Refusal>,
    feed_forward: bool,
    share: f32,
    attitude: Attitude,
    estimator: Estimator,
    operator: OperatorCommand,
    operator_us: Option<u64>,
    trouble: Option<Trouble>,
    verdict: Verdict,
    refused: u32,
    scaled: u32,
    outputs: Outputs,
}

impl<B: Body> Guard<B> {
    /// Guard with these settings.
    ///
    /// # Errors
    /// The robot's, when the settings make none.
    pub fn new(settings: &Settings) -> Result<Self, B::Refusal> {
        Ok(Self {
            sync_period_us: settings.get(Setting::SyncPeriod) as u64,
            next_sync_us: 0,
            judged: false,
            located: false,
            syncs: 0,
            offsets_due: false,
            operator_timeout_us: settings.milliseconds(Setting::OperatorTimeout),
            drives: Drives::new(&B::drive_ids(settings), settings),
            sequence: Sequence::default(),
            body: B::new(settings)?,
            supervision: Supervision::new(settings, B::mass(settings)),
            dead_man: settings.get(Setting::DeadMan) == 1,
            refusal: None,
            feed_forward: settings.get(Setting::FeedForward) == 1,
            share: 1.0,
            attitude: Attitude::default(),
            estimator: Estimator::new(settings),
            operator: OperatorCommand::default(),
            operator_us: None,
            trouble: None,
            verdict: Verdict::Passed,
            refused: 0,
            scaled: 0,
            outputs: Outputs::default(),
        })
    }

    /// One control period. What comes out stays in place until the next: copying the frames would take longer than making them.
    pub fn tick(&mut self, inputs: &Inputs<'_>) -> &Outputs {
        let trouble_before = self.trouble;
        if self.supervision.hear(inputs.body.as_ref())
            && let Some(sensors) = &inputs.body
        {
            self.attitude.update(sensors, super::CONTROL_PERIOD);
            self.estimator
                .sense(sensors.magnetic_field, &mut self.attitude, inputs.now_us);
        }
        self.estimator.listen(inputs.serial, inputs.now_us);
        for frame in inputs.frames {
            self.drives.hear(frame, inputs.now_us);
        }
        self.listen(inputs);
        self.supervise(inputs.now_us);

        self.outputs.frames.clear();
        self.outputs.robot = None;
        let now_us = inputs.now_us;
        let sync_due = now_us >= self.next_sync_us;
        // In the second half and the last quarter of a period, and never later than the next SYNC.
        let half = self.sync_period_us / 2;
        if !self.judged && (sync_due || now_us + half >= self.next_sync_us) {
            self.judged = true;
            self.judge();
        }
        if !self.located && (sync_due || now_us + half / 2 >= self.next_sync_us) {
            self.located = true;
            self.outputs.robot = Some(self.locate(now_us));
            if self.offsets_due && !sync_due {
                self.tell_in_advance();
            }
        }
        if sync_due {
            self.next_sync_us = now_us + self.sync_period_us;
            (self.judged, self.located) = (false, false);
            self.syncs = self.syncs.wrapping_add(1);
            self.offsets_due = self.feed_forward && self.syncs.is_multiple_of(OFFSET_SYNCS);
            self.cycle(inputs);
        }
        self.outputs.emergency = (trouble_before != self.trouble)
            .then(|| self.trouble.map_or(0, |trouble| trouble.code));
        self.tell();
        &self.outputs
    }

    /// What came out of the last tick.
    pub fn outputs(&self) -> &Outputs {
        &self.outputs
    }

    /// Torques that the drives will need.
    fn tell_in_advance(&mut self) {
        if let Some(phase) = self.sequence.phase() {
            let offsets = self.body.offsets(phase, &self.attitude);
            for frame in self.drives.offsets(&offsets) {
                let _ = self.outputs.frames.push(frame); // fewer than there is room for
            }
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
            self.body.acknowledge();
        }
        self.operator = command;
    }

    /// The first fault or loss latches until the operator's reset.
    fn supervise(&mut self, now_us: u64) {
        if self.trouble.is_none() && self.sequence.state() != State::Waiting {
            self.trouble = self.drives.trouble(now_us, self.sequence.driving());
        }
    }

    /// Period of SYNC, s; at most 100 ms.
    fn period(&self) -> f32 {
        self.sync_period_us as u32 as f32 * 1e-6
    }

    /// What happens once between two SYNCs, when the drives have answered the first: how the robot stands and what that means. Apart from
    /// [`Self::cycle`], so that no tick has to do it all.
    #[inline(never)]
    fn judge(&mut self) {
        let period = self.period();
        if let Some(speed) = self.estimator.take_speed(&self.attitude) {
            self.body.hear_speed(speed, &self.attitude);
        }
        self.body
            .observe(self.drives.states(), &self.attitude, period);
        let stance = self.body.stance(&self.attitude);
        self.supervision
            .judge(&stance, &self.attitude, self.body.speed(), period);
    }

    /// What happens once per SYNC: filter, body, sequence, set-points.
    fn cycle(&mut self, inputs: &Inputs<'_>) {
        let now_us = inputs.now_us;
        let period = self.period();
        let request = Request::from_byte(self.operator.request);
        let before = self.sequence.state();
        let refused = self.refusal.is_some() && request == Request::Arm;
        let started = self.sequence.advance(
            if refused { Request::Stop } else { request },
            self.trouble.is_some(),
            &self.drives,
            &mut self.body,
            now_us,
        );
        let armed_now = before != State::Armed && self.sequence.state() == State::Armed;
        self.check(armed_now, request);
        self.dispose(request, inputs, period);

        // Room for all of them: MAX_SENT.
        let frames = &mut self.outputs.frames;
        let _ = frames.push(sync());
        if started {
            let _ = frames.push(nmt(NmtCommand::Start, 0));
        }
        if self.sequence.state() != State::Waiting {
            let goal = |drive| self.sequence.goal(drive, &self.body);
            for frame in self.drives.commands(goal) {
                let _ = frames.push(frame);
            }
        }
    }

    /// Refuses to arm a robot whose geometry and settings make no sense on level ground, until it is disarmed.
    fn check(&mut self, armed_now: bool, request: Request) {
        if armed_now {
            let level = self.body.stance(&Attitude::default());
            self.refusal = self.supervision.check(&level).err();
        } else if request == Request::Disarm {
            self.refusal = None;
        }
        if armed_now && self.refusal.is_some() {
            self.sequence.disarm();
        }
    }

    /// Passes the operator's command on to the body, as far as supervision and margins allow.
    fn dispose(&mut self, request: Request, inputs: &Inputs<'_>, period: f32) {
        let heard = self
            .operator_us
            .is_some_and(|heard| inputs.now_us.saturating_sub(heard) <= self.operator_timeout_us);
        let held = !self.dead_man || self.operator.request & DEAD_MAN_HELD != 0;
        let armed = self.sequence.state() == State::Armed;
        let moment = Moment {
            now_us: inputs.now_us,
            armed,
            attended: heard && held,
            drives: request == Request::Arm,
            requests: Requests {
                reset: request == Request::Reset,
                override_trip: request == Request::Override && heard,
                back_off: request == Request::BackOff && heard,
                emergency_stop: inputs.emergency_stop || request == Request::EmergencyStop,
            },
        };
        let asked = Asked {
            forward: f32::from(self.operator.forward) * 1e-3,
            yaw_rate: f32::from(self.operator.yaw_rate) * 1e-3,
            posture: self.operator.posture,
        };
        let (posture, speed) = (self.body.posture(), self.body.speed());
        let (asked, admitted) = self.supervision.admit(asked, posture, speed, &moment);
        let ahead =
            self.body
                .stance_ahead(&asked, &self.attitude, self.supervision.horizon(), period);
        let pitch = self.attitude.pitch().radians();
        let (allowed, filtered) =
            self.supervision
                .filter(&asked, &ahead, pitch, self.body.stopping_time());
        if !armed {
            self.body.rest();
            self.share = 1.0;
            self.count(Verdict::Passed);
            return;
        }
        let asked = Asked {
            yaw_rate: allowed.limits.yaw_rate(asked.yaw_rate, speed),
            ..asked
        };
        self.share = allowed.share;
        self.body.advance(&asked, allowed, &self.attitude, period);
        let passed = admitted == Verdict::Passed;
        self.count(if passed { filtered } else { admitted });
    }

    /// What the guard knows of the robot's balance.
    pub fn telemetry(&self) -> Telemetry {
        self.supervision.telemetry(self.refusal)
    }

    fn count(&mut self, verdict: Verdict) {
        let kind = |verdict: Verdict| verdict.code() >> 4;
        if kind(verdict) != kind(self.verdict) {
            match verdict {
                Verdict::Passed => {}
                Verdict::Scaled(_) | Verdict::PostureScaled(_) | Verdict::Doubted(_) => {
                    self.scaled = self.scaled.saturating_add(1);
                }
                Verdict::Refused(_)
                | Verdict::PostureRefused(_)
                | Verdict::Blind(_)
                | Verdict::EmergencyStopped
                | Verdict::Tripped(_)
                | Verdict::Overridden(_)
                | Verdict::BackingOff(_)
                | Verdict::Unattended => {
                    self.refused = self.refused.saturating_add(1);
                }
            }
        }
        self.verdict = verdict;
    }

    /// Fills in what every tick tells.
    fn tell(&mut self) {
        let centidegrees = |radians: f32| to_i16(radians.to_degrees() * 100.0);
        let millimetres = |metres: f32| to_i16(metres * 1e3);
        let [back, front, left, right] = self.supervision.margins().now.map(millimetres);
        let trouble = self.trouble.unwrap_or(Trouble { node: 0, code: 0 });
        let outputs = &mut self.outputs;
        outputs.motion = GuardMotion {
            odometry: self.body.odometry_um(),
            pitch: centidegrees(self.attitude.pitch().radians()),
            roll: centidegrees(self.attitude.roll().radians()),
        };
        outputs.state = GuardState {
            state: self.sequence.state().code(),
            verdict: self.verdict.code(),
            scale: to_i16(self.share * 100.0) as u8,
            fault_node: trouble.node,
            fault_code: trouble.code,
            heading: (self.attitude.heading().to_bits() >> 16) as i16,
        };
        outputs.margins = GuardMargins {
            back,
            front,
            left,
            right,
        };
        outputs.passed = GuardPassed {
            asked_speed: self.operator.forward,
            passed_speed: millimetres(self.body.speed()),
            asked_posture: self.operator.posture,
            passed_posture: self.body.posture(),
        };
        outputs.refused = self.refused;
        outputs.scaled = self.scaled;
    }
}
