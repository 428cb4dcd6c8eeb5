//! The order in which the drives come to life. The stages between "ready" and "armed" are the robot's own.

use super::drives::Drives;
use crate::bus::pdo::Request;
use crate::robots::{Body, Goal, MAX_STAGES, Phase};

/// State of the guard (object 0x4001:1).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum State {
    /// Not all nodes were heard yet.
    #[default]
    Waiting,
    /// Motors off.
    Ready,
    /// The drives come to life; the number of the stage.
    Waking(u8),
    /// The operator drives.
    Armed,
    /// A fault or a loss holds the robot until the operator's reset.
    Held,
}

const FIRST_STAGE: u8 = 2;
const ARMED: u8 = FIRST_STAGE + MAX_STAGES as u8;
const HELD: u8 = ARMED + 1;

impl State {
    /// The state with this number.
    pub fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0 => Self::Waiting,
            1 => Self::Ready,
            FIRST_STAGE..ARMED => Self::Waking(code - FIRST_STAGE),
            ARMED => Self::Armed,
            HELD => Self::Held,
            _ => return None,
        })
    }

    /// Its number: 0 waiting, 1 ready, 2 to 5 the robot's stages, 6 armed, 7 held.
    pub fn code(self) -> u8 {
        match self {
            Self::Waiting => 0,
            Self::Ready => 1,
            Self::Waking(stage) => FIRST_STAGE + stage,
            Self::Armed => ARMED,
            Self::Held => HELD,
        }
    }

    /// Its name, as logs and reports show it, on a robot with these [`Body::STAGES`].
    pub fn name(self, stages: &[&'static str]) -> &'static str {
        match self {
            Self::Waiting => "waiting for nodes",
            Self::Ready => "ready",
            Self::Waking(stage) => stages.get(usize::from(stage)).unwrap_or(&"waking"),
            Self::Armed => "armed",
            Self::Held => "held",
        }
    }
}

#[derive(Clone, Debug, Default)]
pub(super) struct Sequence {
    state: State,
}

impl Sequence {
    pub fn state(&self) -> State {
        self.state
    }

    /// The drives are under power or were when a fault came.
    pub fn driving(&self) -> bool {
        !matches!(self.state, State::Waiting | State::Ready)
    }

    /// Back to "ready": the robot is not fit to be armed.
    pub fn disarm(&mut self) {
        if self.driving() && self.state != State::Held {
            self.state = State::Ready;
        }
    }

    /// Takes one SYNC period; true when the network is to be started: at first, and after a node may have started anew.
    pub fn advance<B: Body>(
        &mut self,
        request: Request,
        trouble: bool,
        drives: &Drives,
        body: &mut B,
        now_us: u64,
    ) -> bool {
        let before = self.state;
        self.state = match before {
            State::Waiting if drives.all_seen() => State::Ready,
            State::Waiting => State::Waiting,
            State::Held if !trouble => State::Ready,
            State::Held => State::Held,
            State::Ready if trouble => State::Ready,
            _ if trouble => State::Held,
            _ if request == Request::Disarm => State::Ready,
            State::Ready if request == Request::Arm => {
                State::Waking(body.first_stage(drives.states()))
            }
            State::Waking(stage) if body.reached(stage, drives.states(), now_us) => {
                let next = stage + 1;
                if usize::from(next) < B::STAGES.len() {
                    State::Waking(next)
                } else {
                    State::Armed
                }
            }
            state => state,
        };
        matches!(before, State::Waiting | State::Held) && self.state == State::Ready
    }

    /// What drive number `drive` shall do in the present state.
    pub fn goal<B: Body>(&self, drive: usize, body: &B) -> Goal {
        match self.state {
            State::Waiting | State::Ready => Goal::Off,
            State::Waking(stage) => body.goal(Phase::Waking(stage), drive),
            State::Armed => body.goal(Phase::Armed, drive),
            State::Held => body.goal(Phase::Held, drive),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_survive_their_codes() {
        for code in 0..=u8::MAX {
            if let Some(state) = State::from_code(code) {
                assert_eq!(state.code(), code);
            }
        }
        assert_eq!(State::from_code(HELD + 1), None);
    }
}
