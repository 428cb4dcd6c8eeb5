//! The states of the guard. The stages between "ready" and "armed" depend on the robot.
//!
//! ```text
//!            all drives         a new request          the last stage
//!            have answered      to arm                 is reached
//!  Waiting ───────────► Ready ───────────► Starting(n) ───────────► Armed
//!                       ▲ ▲ ▲                │  │  ▲ │                │ │
//!                       │ │ └── disarm, ─────┘  │  └─┘ next stage     │ │
//!                       │ │     start refused   │                     │ │
//!                       │ └──── disarm ─────────┼─────────────────────┘ │
//!                       │                       │ a fault is            │
//!                       │ the fault is reset    ▼ reported              │
//!                       └───────────────────── Held ◄───────────────────┘
//! ```
//!
//! A fault in "ready" prevents arming. "Armed" also waits until the attitude has settled. Before
//! it, the guard checks the settings; if it refuses them, "ready" follows (`cycle`).

use crate::robots::{Body, DriveState, MAX_STAGES, Phase};

/// State of the guard (object 0x4001:1).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum State {
    /// Not every drive has answered yet.
    #[default]
    Waiting,
    /// Disarmed. A drive that holds keeps holding unless the operator requests motors off.
    Ready,
    /// The drives are being homed and enabled. The value is the number of the stage.
    Starting(u8),
    /// The operator drives the robot.
    Armed,
    /// A fault report holds the robot until the operator's reset.
    Held,
}

const FIRST_STAGE: u8 = 2;
const ARMED: u8 = FIRST_STAGE + MAX_STAGES as u8;
const HELD: u8 = ARMED + 1;

impl State {
    /// Returns the state with this code.
    pub fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0 => Self::Waiting,
            1 => Self::Ready,
            FIRST_STAGE..ARMED => Self::Starting(code - FIRST_STAGE),
            ARMED => Self::Armed,
            HELD => Self::Held,
            _ => return None,
        })
    }

    /// Returns the code of the state: 0 waiting, 1 ready, 2 to 5 the robot's stages, 6 armed, 7
    /// held.
    pub fn code(self) -> u8 {
        match self {
            Self::Waiting => 0,
            Self::Ready => 1,
            Self::Starting(stage) => FIRST_STAGE + stage,
            Self::Armed => ARMED,
            Self::Held => HELD,
        }
    }

    /// Returns the name of the state, as in logs and reports, for a robot with these
    /// [`Body::STAGES`].
    pub fn name(self, stages: &[&'static str]) -> &'static str {
        match self {
            Self::Waiting => "waiting for nodes",
            Self::Ready => "ready",
            Self::Starting(stage) => stages.get(usize::from(stage)).unwrap_or(&"starting"),
            Self::Armed => "armed",
            Self::Held => "held",
        }
    }

    /// Returns whether the drives are under power, or were when a fault was reported.
    pub fn driving(self) -> bool {
        !matches!(self, Self::Waiting | Self::Ready)
    }

    /// Returns what the robot is about to do; `None` while it is disarmed.
    pub fn phase(self) -> Option<Phase> {
        match self {
            Self::Waiting | Self::Ready => None,
            Self::Starting(stage) => Some(Phase::Starting(stage)),
            Self::Armed => Some(Phase::Armed),
            Self::Held => Some(Phase::Held),
        }
    }
}

/// Conditions that decide the next state.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::struct_excessive_bools)] // independent facts, not states
pub(super) struct Conditions {
    /// Every drive has answered, and its position scale is known.
    pub complete: bool,
    /// A fault report is latched, or a reset of the drives is under way.
    pub fault: bool,
    /// The operator requests motors off.
    pub disarms: bool,
    /// The operator makes a new request to arm.
    pub arms: bool,
    /// The start is refused.
    pub refused: bool,
    /// The gate is open, so that a stage makes progress.
    pub open: bool,
    /// The first readings of the attitude still change it, or the robot has not rested yet. An
    /// armed guard would take the change for a motion of the robot.
    pub settling: bool,
}

/// Returns the state after one SYNC period.
pub(super) fn next<B: Body>(
    state: State,
    conditions: Conditions,
    body: &mut B,
    drives: &[DriveState],
    now_us: u64,
) -> State {
    match state {
        State::Waiting if conditions.complete => State::Ready,
        State::Waiting => State::Waiting,
        State::Held if conditions.fault => State::Held,
        State::Held => State::Ready,
        State::Ready if conditions.fault => State::Ready,
        _ if conditions.fault => State::Held,
        _ if conditions.disarms => State::Ready,
        State::Starting(_) if conditions.refused => State::Ready,
        State::Ready if conditions.arms => State::Starting(body.first_stage(drives)),
        State::Starting(stage) if conditions.open && body.reached(stage, drives, now_us) => {
            let next = stage + 1;
            if usize::from(next) < B::STAGES.len() {
                State::Starting(next)
            } else if conditions.settling {
                state
            } else {
                State::Armed
            }
        }
        State::Ready | State::Starting(_) | State::Armed => state,
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

    /// Clients and logs know the states by these codes.
    #[test]
    fn the_code_of_a_state_is_the_documented_one() {
        let stages = (0..4).map(State::Starting);
        let states = [State::Waiting, State::Ready].into_iter().chain(stages);
        for (code, state) in states.chain([State::Armed, State::Held]).enumerate() {
            assert_eq!(usize::from(state.code()), code, "{state:?}");
            assert_eq!(State::from_code(code as u8), Some(state));
        }
    }

    #[test]
    fn a_state_has_the_name_of_its_stage() {
        let names = [
            State::Waiting,
            State::Ready,
            State::Starting(1),
            State::Starting(9),
            State::Armed,
            State::Held,
        ]
        .map(|state| state.name(&["homing", "raising"]));
        let expected = [
            "waiting for nodes",
            "ready",
            "raising",
            "starting",
            "armed",
            "held",
        ];
        assert_eq!(names, expected);
    }

    #[test]
    fn a_robot_drives_or_was_driving_in_every_state_but_waiting_and_ready() {
        for code in 0..=7 {
            let state = State::from_code(code).unwrap();
            assert_eq!(state.driving(), code >= 2, "{state:?}");
            assert_eq!(state.phase().is_some(), code >= 2, "{state:?}");
        }
    }
}
