//! The gate that every goal of every drive passes, in every state of the guard.

use super::sequence::State;
use crate::robots::{DriveState, Goal};

/// What the guard allows its drives in one SYNC period.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Gate {
    /// All bridges are off, because the operator requested it.
    Off,
    /// Every drive under power brakes and holds, and no drive is enabled.
    Hold,
    /// A drive that is enabled keeps its goal, and every other drive holds.
    Keep,
    /// Every goal passes.
    Open,
}

impl Gate {
    /// Returns the gate in `state`. `disarms`: the operator requests motors off. `drives`: the
    /// operator attends and requests to arm, and no trip is latched.
    pub fn of(state: State, disarms: bool, drives: bool) -> Self {
        match state {
            _ if disarms => Self::Off,
            State::Waiting | State::Ready => Self::Hold,
            State::Starting(_) if drives => Self::Open,
            State::Starting(_) => Self::Hold,
            // The filter stops an armed robot, because it knows how hard the robot may brake.
            State::Armed => Self::Open,
            State::Held => Self::Keep,
        }
    }

    /// Returns the goal that `drive` gets if the robot's body commands `goal`.
    pub fn pass(self, goal: Goal, drive: &DriveState) -> Goal {
        match self {
            Self::Off => Goal::Off,
            Self::Hold => Goal::Hold,
            Self::Keep if drive.enabled => goal,
            Self::Keep => Goal::Hold,
            Self::Open => goal,
        }
    }
}
