//! The guard: master of the network, body controller of the robot it is built for ([`crate::robots::Body`]) and, above both,
//! the filter that passes a command on only as far as the margins allow.
//!
//! [`drives`] and [`drive`] hold what the guard knows of the other nodes, [`scales`] compares their
//! units, [`operator`] holds the newest command, [`schedule`] says what is due, [`sequence`] holds the
//! states, [`gate`] what the drives may do in each of them, [`supervision`] the robot's balance,
//! [`publish`] what the guard tells. This file is the tick.

mod drive;
mod drives;
mod gate;
mod operator;
mod publish;
mod scales;
mod schedule;
mod sequence;
mod supervision;

pub use drives::ScaleMismatch;
pub use scales::POSITION_SCALE;
pub use sequence::State;
pub use supervision::Telemetry;

use crate::bus::network::{NmtCommand, nmt, sync};
use crate::bus::pdo::{
    GuardMargins, GuardMotion, GuardPassed, GuardPosition, GuardState, OperatorCommand, Request,
};
use crate::can::Frame;
use crate::constants::CONTROL_PERIOD;
use crate::estimate::state::{Estimator, State as RobotState};
use crate::robots::{Asked, Body, DriveState, Goal, MAX_DRIVES, PostureCommand};
use crate::sensors::BodySensors;
use crate::settings::Settings;
use crate::stability::attitude::Attitude;
use crate::stability::parameters::Refusal;
use crate::stability::trip::Requests;
use crate::stability::verdict::Verdict;
use drives::Drives;
use gate::Gate;
use heapless::Vec;
use operator::Operator;
use publish::Tally;
use schedule::Schedule;
use sequence::Conditions;
use supervision::{Moment, Supervision};

/// Largest number of frames that one tick sends: SYNC, network management, and for each drive a
/// set-point or a request for its scale.
pub const MAX_SENT: usize = 2 * MAX_DRIVES + 2;

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
    /// The drives that have a fault, a bit for each in the order of `Body::drive_ids` (object 0x4009).
    pub faulty_drives: u16,
}

/// A node's fault or loss that holds the robot.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct FaultReport {
    node: u8,
    code: u16,
}

/// State of the guard.
#[derive(Clone, Debug)]
pub struct Guard<B> {
    schedule: Schedule,
    drives: Drives,
    state: State,
    gate: Gate,
    body: B,
    supervision: Supervision,
    refusal: Option<Refusal>,
    share: f32,
    attitude: Attitude,
    estimator: Estimator,
    operator: Operator,
    /// Reset and emergency stop since the last SYNC.
    requests: Requests,
    fault: Option<FaultReport>,
    tally: Tally,
    outputs: Outputs,
}

impl<B: Body> Guard<B> {
    /// Guard with these settings.
    ///
    /// # Errors
    /// The robot's, when the settings make none.
    pub fn new(settings: &Settings) -> Result<Self, B::Refusal> {
        Ok(Self {
            schedule: Schedule::new(settings),
            drives: Drives::new::<B>(settings),
            state: State::default(),
            gate: Gate::Hold,
            body: B::new(settings)?,
            supervision: Supervision::new(settings, B::mass(settings), B::step_behind(settings)),
            refusal: None,
            share: 1.0,
            attitude: Attitude::default(),
            estimator: Estimator::new(settings),
            operator: Operator::new(settings),
            requests: Requests::default(),
            fault: None,
            tally: Tally::default(),
            outputs: Outputs::default(),
        })
    }

    /// One control period. What comes out stays in place until the next: copying the frames would take longer than making them.
    pub fn tick(&mut self, inputs: &Inputs<'_>) -> &Outputs {
        let fault_before = self.fault;
        if self.supervision.hear(inputs.body.as_ref())
            && let Some(sensors) = &inputs.body
        {
            self.attitude.update(sensors, CONTROL_PERIOD);
            self.estimator
                .sense(sensors.magnetic_field, &mut self.attitude, inputs.now_us);
        }
        self.estimator.listen(inputs.serial, inputs.now_us);
        for frame in inputs.frames {
            self.drives.receive(frame, inputs.now_us);
        }
        self.listen(inputs);
        self.supervise(inputs.now_us);

        self.outputs.frames.clear();
        self.outputs.robot = None;
        let due = self.schedule.due(inputs.now_us);
        if due.judgement {
            self.judge();
        }
        if due.position {
            self.outputs.robot = Some(self.locate(inputs.now_us));
        }
        if due.offsets {
            self.tell_in_advance();
        }
        if due.sync {
            self.cycle(inputs);
        }
        self.outputs.emergency =
            (fault_before != self.fault).then(|| self.fault.map_or(0, |fault| fault.code));
        self.tell();
        &self.outputs
    }

    /// What came out of the last tick.
    pub fn outputs(&self) -> &Outputs {
        &self.outputs
    }

    /// Torques that the drives will need.
    fn tell_in_advance(&mut self) {
        if let Some(phase) = self.state.phase() {
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
            self.drives.odometry_us::<B>(),
            self.body.joints(self.drives.states()),
            &self.attitude,
            now_us,
        );
        let state = self.estimator.state(&self.attitude, now_us);
        (state, publish::position(&state))
    }

    /// Where the robot's position is counted from, and what became of the satellite receiver's sentences.
    pub fn estimator(&self) -> &Estimator {
        &self.estimator
    }

    /// Takes the operator's command; a request that has changed to "reset" acknowledges everything.
    fn listen(&mut self, inputs: &Inputs<'_>) {
        self.requests.emergency_stop |= inputs.emergency_stop;
        let Some(command) = inputs.operator else {
            return;
        };
        let resets = self.operator.receive(command, inputs.now_us);
        self.requests.emergency_stop |= self.operator.request() == Request::EmergencyStop;
        self.requests.reset |= resets;
        if resets {
            self.fault = None;
            self.drives.begin_reset();
            self.body.acknowledge();
        }
    }

    /// The first fault report latches until the operator's reset.
    fn supervise(&mut self, now_us: u64) {
        if self.fault.is_none() && self.state != State::Waiting {
            self.fault = self.drives.fault(now_us, self.state.driving());
        }
    }

    /// What happens once between two SYNCs, when the drives have answered the first: how the robot stands and what that means. Apart from
    /// [`Self::cycle`], so that no tick has to do it all.
    #[inline(never)]
    fn judge(&mut self) {
        let period = self.schedule.period();
        if let Some(speed) = self.estimator.take_speed(&self.attitude) {
            self.body.hear_speed(speed, &self.attitude);
        }
        self.body
            .observe(self.drives.states(), &self.attitude, period);
        let stance = self.body.stance(&self.attitude);
        let kept_shape = self.body.stance_with_kept_shape(&self.attitude);
        let speed = self.body.speed();
        self.supervision
            .judge(&stance, kept_shape.as_ref(), &self.attitude, speed, period);
    }

    /// What happens once per SYNC: state, filter, body, gate, set-points.
    fn cycle(&mut self, inputs: &Inputs<'_>) {
        let now_us = inputs.now_us;
        let before = self.state;
        self.drives.check_restarts(before.driving());
        self.advance_state(now_us);
        self.pass_command(inputs);
        // Behind the filter: a trip or an emergency stop counts in the period in which it comes.
        let drives = self.operator.request() == Request::Arm
            && self.operator.attends(now_us)
            && !self.supervision.tripped();
        self.gate = Gate::of(self.state, self.operator.disarms(now_us), drives);
        let starting = self.gate == Gate::Open && self.state == before;
        if self.state != State::Armed && !starting {
            self.body.rest();
        }
        // A drive that has started anew waits for it in "held", too: its reset needs its status.
        let joined = before == State::Waiting && self.state == State::Ready;
        let waits = matches!(self.state, State::Ready | State::Held) && self.drives.take_start();
        self.send(joined || waits, now_us);
    }

    /// Takes the state that follows from fault reports, drives and the operator's request.
    fn advance_state(&mut self, now_us: u64) {
        let before = self.state;
        let ready = self.drives.ready_to_arm();
        let conditions = Conditions {
            complete: self.drives.complete(),
            fault: self.fault.is_some() || self.drives.reset_under_way(),
            disarms: self.operator.disarms(now_us),
            arms: ready && self.operator.arms(now_us) && !self.supervision.tripped(),
            open: self.gate == Gate::Open,
        };
        let drives = self.drives.states();
        self.state = sequence::next(before, conditions, &mut self.body, drives, now_us);
        if conditions.disarms {
            self.refusal = None;
        }
        match (before, self.state) {
            (State::Ready, State::Waking(_)) => {
                self.refusal = None;
                self.operator.require_new_request();
            }
            (before, State::Held) if before != State::Held => {
                self.operator.require_new_request();
            }
            (State::Waking(_), State::Armed) => self.check(),
            _ => {}
        }
    }

    /// Refuses to arm a robot whose geometry and settings make no sense on level ground.
    fn check(&mut self) {
        let level = self.body.stance(&Attitude::default());
        self.refusal = self.supervision.check(&level).err();
        if self.refusal.is_some() {
            self.state = State::Ready;
        }
    }

    /// The frames of one SYNC period; `starts` begins the exchange of process data.
    fn send(&mut self, starts: bool, now_us: u64) {
        self.drives.note_sent(starts);
        // Room for all of them: MAX_SENT.
        let frames = &mut self.outputs.frames;
        let _ = frames.push(sync());
        if starts {
            let _ = frames.push(nmt(NmtCommand::Start, 0));
        }
        if !self.state.driving() {
            for frame in self.drives.scale_requests(now_us) {
                let _ = frames.push(frame);
            }
        }
        if self.state == State::Waiting {
            return;
        }
        let (gate, body, phase) = (self.gate, &self.body, self.state.phase());
        let goal = |drive, state: &DriveState| {
            let goal = phase.map_or(Goal::Hold, |phase| body.goal(phase, drive));
            gate.pass(goal, state)
        };
        for frame in self.drives.commands(now_us, goal) {
            let _ = frames.push(frame);
        }
    }

    /// Passes the operator's command on to the body, as far as supervision and margins allow.
    fn pass_command(&mut self, inputs: &Inputs<'_>) {
        let (now_us, period) = (inputs.now_us, self.schedule.period());
        let request = self.operator.request();
        let present = self.operator.present(now_us);
        let seen = core::mem::take(&mut self.requests);
        let armed = self.state == State::Armed;
        let moment = Moment {
            now_us,
            armed,
            attended: self.operator.attends(now_us),
            drives: request == Request::Arm,
            requests: Requests {
                override_trip: request == Request::Override && present,
                back_off: request == Request::BackOff && present,
                // However short they were since the SYNC before.
                reset: seen.reset,
                emergency_stop: seen.emergency_stop || request == Request::EmergencyStop,
            },
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
            self.share = 1.0;
            self.tally.count(Verdict::Passed);
            return;
        }
        let asked = Asked {
            yaw_rate: allowed.limits.yaw_rate(asked.yaw_rate, speed),
            ..asked
        };
        self.share = allowed.share;
        self.body.advance(&asked, allowed, &self.attitude, period);
        let passed = admitted == Verdict::Passed;
        self.tally.count(if passed { filtered } else { admitted });
    }

    /// What the guard knows of the robot's balance.
    pub fn telemetry(&self) -> Telemetry {
        self.supervision.telemetry(self.refusal)
    }

    /// The first drive whose scale differs from the one that the robot's equations use.
    pub fn scale_mismatch(&self) -> Option<ScaleMismatch> {
        self.drives.mismatch()
    }
}
