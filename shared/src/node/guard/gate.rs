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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motors_off_opens_every_bridge_and_only_a_driving_operator_starts_the_robot() {
        for code in 0..=7 {
            let state = State::from_code(code).unwrap();
            for drives in [false, true] {
                assert_eq!(Gate::of(state, true, drives), Gate::Off);
                let expected = match code {
                    0 | 1 => Gate::Hold,
                    6 => Gate::Open,
                    7 => Gate::Keep,
                    _ if drives => Gate::Open,
                    _ => Gate::Hold,
                };
                assert_eq!(Gate::of(state, false, drives), expected, "{state:?}");
            }
        }
    }

    #[test]
    fn a_gate_that_is_not_open_lets_no_drive_start() {
        for enabled in [false, true] {
            let drive = DriveState {
                enabled,
                ..DriveState::default()
            };
            let passed = [Gate::Off, Gate::Hold, Gate::Keep, Gate::Open]
                .map(|gate| gate.pass(Goal::Home, &drive));
            let kept = if enabled { Goal::Home } else { Goal::Hold };
            assert_eq!(passed, [Goal::Off, Goal::Hold, kept, Goal::Home]);
        }
    }
}
