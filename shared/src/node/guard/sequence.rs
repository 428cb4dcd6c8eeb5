//! The order in which the drives come to life, as a table of stages.
//!
//! The belt cannot be torn: the screw first draws back to where the belt is slack at any chassis angle, only then does
//! the joint look for its reference, and the screw takes the belt up again last.

use super::body::Body;
use super::drives::{Drives, Goal, Role};
use crate::bus::pdo::Request;
use crate::node::cia402::State as DriveState;

/// State of the guard (object 0x4001:1).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum State {
    /// Not all nodes were heard yet.
    #[default]
    Waiting = 0,
    /// Motors off.
    Ready = 1,
    /// The screw draws back and finds its reference.
    ReferencingScrew = 2,
    /// The joint finds its reference, the belt slack.
    ReferencingJoint = 3,
    /// The joint goes to 0.
    Straightening = 4,
    /// The screw takes up the belt.
    Tightening = 5,
    /// The operator drives.
    Armed = 6,
    /// A fault or a loss holds the robot until the operator's reset.
    Held = 7,
}

impl State {
    /// The state with this number.
    pub fn from_byte(byte: u8) -> Option<Self> {
        use State::{
            Armed, Held, Ready, ReferencingJoint, ReferencingScrew, Straightening, Tightening,
            Waiting,
        };
        [
            Waiting,
            Ready,
            ReferencingScrew,
            ReferencingJoint,
            Straightening,
            Tightening,
            Armed,
            Held,
        ]
        .into_iter()
        .find(|state| *state as u8 == byte)
    }

    /// Its name, as logs and reports show it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Waiting => "waiting for nodes",
            Self::Ready => "ready",
            Self::ReferencingScrew => "referencing screw",
            Self::ReferencingJoint => "referencing joint",
            Self::Straightening => "straightening",
            Self::Tightening => "tightening",
            Self::Armed => "armed",
            Self::Held => "held",
        }
    }
}

/// Largest distance from a target that counts as there: joint 2^-32 turn (0.5 degree), screw 2^-24 m (0.5 mm).
const JOINT_THERE: u32 = 5_965_232;
const SCREW_THERE: u32 = 8_389;

#[derive(Clone, Debug, Default)]
pub(super) struct Sequence {
    state: State,
    tighten_since_us: Option<u64>,
}

impl Sequence {
    pub fn state(&self) -> State {
        self.state
    }

    /// The drives are under power or were when a fault came.
    pub fn driving(&self) -> bool {
        !matches!(self.state, State::Waiting | State::Ready)
    }

    /// Takes one SYNC period; true when the network is to be started: at first, and after a node may have started anew.
    pub fn advance(
        &mut self,
        request: Request,
        trouble: bool,
        drives: &Drives,
        body: &Body,
        now_us: u64,
    ) -> bool {
        let screw_away = drives
            .of(Role::Screw)
            .position()
            .abs_diff(body.released_bus());
        let there = match self.state {
            State::Waiting => drives.all(super::Drive::seen),
            State::Ready => request == Request::Arm,
            State::ReferencingScrew => {
                drives.of(Role::Screw).referenced()
                    && (body.joint_known() || screw_away < SCREW_THERE)
            }
            State::ReferencingJoint => drives.of(Role::Joint).referenced(),
            State::Straightening => drives.of(Role::Joint).position().unsigned_abs() < JOINT_THERE,
            State::Tightening => self.tight(drives, body, now_us),
            State::Armed => false,
            State::Held => !trouble,
        };
        let before = self.state;
        self.state = match (before, request) {
            (State::Waiting, _) if there => State::Ready,
            (State::Waiting, _) => State::Waiting,
            (State::Held, _) if there => State::Ready,
            (State::Ready, _) if trouble => State::Ready,
            (_, _) if trouble => State::Held,
            (State::Held, _) => State::Held,
            (_, Request::Disarm) => State::Ready,
            (State::Ready, _) if there && drives.all(super::Drive::referenced) => State::Tightening,
            (State::Ready, _) if there => State::ReferencingScrew,
            (State::ReferencingScrew, _) if there => State::ReferencingJoint,
            (State::ReferencingJoint, _) if there => State::Straightening,
            (State::Straightening, _) if there => State::Tightening,
            (State::Tightening, _) if there => State::Armed,
            (state, _) => state,
        };
        if self.state != State::Tightening {
            self.tighten_since_us = None;
        }
        matches!(before, State::Waiting | State::Held) && self.state == State::Ready
    }

    /// All drives enabled and the screw on the law of the belt for 100 ms.
    fn tight(&mut self, drives: &Drives, body: &Body, now_us: u64) -> bool {
        let enabled = drives.all(|drive| drive.state() == Some(DriveState::OperationEnabled));
        let away = drives.of(Role::Screw).position().abs_diff(body.taut_bus());
        if !enabled || away >= SCREW_THERE {
            self.tighten_since_us = None;
            return false;
        }
        let since = *self.tighten_since_us.get_or_insert(now_us);
        now_us.saturating_sub(since) >= 100_000
    }

    /// What `role` shall do in the present state.
    pub fn goal(&self, role: Role, body: &Body) -> Goal {
        match (self.state, role) {
            (State::Waiting | State::Ready, _) => Goal::Off,
            (State::ReferencingScrew, Role::Screw) if body.screw_known() => {
                Goal::MoveTo(body.released_bus())
            }
            (State::ReferencingScrew, Role::Screw) => Goal::Reference,
            (State::ReferencingScrew, _) => Goal::Off,
            (State::ReferencingJoint | State::Straightening, Role::Screw) => {
                Goal::MoveTo(body.released_bus())
            }
            (State::ReferencingJoint, Role::Joint) => Goal::Reference,
            (State::Straightening, Role::Joint) => Goal::MoveTo(0),
            (State::ReferencingJoint | State::Straightening, _) => Goal::Off,
            (State::Tightening | State::Armed, Role::Screw) => Goal::Taut,
            (State::Tightening | State::Armed, Role::Joint) => Goal::Position(body.joint_bus()),
            (State::Tightening | State::Armed, Role::Left) => {
                Goal::Velocity(body.track_speeds()[0])
            }
            (State::Tightening | State::Armed, Role::Right) => {
                Goal::Velocity(body.track_speeds()[1])
            }
            // The belt stays taut as long as the screw can keep it so.
            (State::Held, Role::Screw) if body.joint_known() => Goal::Taut,
            (State::Held, _) => Goal::Hold,
        }
    }
}
