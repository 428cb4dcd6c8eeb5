//! The gate that every goal of every drive passes, in every state of the guard.
//!
//! A drive that holds goes on holding in every state: only the operator's "disarm" leads to
//! [`Goal::Off`].

use super::sequence::State;
use crate::robots::{DriveState, Goal};

/// What the guard allows its drives in one SYNC period.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Gate {
    /// All bridges are off, because the operator requested it.
    Off,
    /// Every drive under power brakes and holds, and no drive is enabled.
    Hold,
    /// As [`Self::Hold`], and a drive that turns freely is enabled, to brake.
    Brake,
    /// A drive that is enabled keeps its goal; for every other drive as [`Self::Brake`].
    Keep,
    /// Every goal passes.
    Open,
}

/// The operator's part in what the gate allows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Intent {
    /// No command has come, or the last one was "disarm" and the operator has fallen silent.
    Nothing,
    /// Motors off.
    Disarm,
    /// Any other request, and no operator after it.
    Stand,
    /// A present operator requests to arm, and no trip is latched.
    Drive,
}

impl Gate {
    /// Returns the gate in `state`.
    pub fn of(state: State, intent: Intent) -> Self {
        match (state, intent) {
            (_, Intent::Disarm) => Self::Off,
            // The filter stops an armed robot, because it knows how hard the robot may brake.
            (State::Armed, _) | (State::Starting(_), Intent::Drive) => Self::Open,
            (_, Intent::Nothing) => Self::Hold,
            (State::Held, _) => Self::Keep,
            (_, Intent::Stand | Intent::Drive) => Self::Brake,
        }
    }

    /// Returns the goal that `drive` gets if the robot's body commands `goal`.
    pub fn pass(self, goal: Goal, drive: &DriveState) -> Goal {
        match self {
            Self::Off => Goal::Off,
            Self::Open => goal,
            Self::Keep if drive.enabled => goal,
            Self::Brake | Self::Keep if drive.turns_freely => Goal::Velocity(0.0),
            Self::Hold | Self::Brake | Self::Keep => Goal::Hold,
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
            assert_eq!(Gate::of(state, Intent::Disarm), Gate::Off);
            for intent in [Intent::Nothing, Intent::Stand, Intent::Drive] {
                let expected = match code {
                    6 => Gate::Open,
                    _ if intent == Intent::Nothing => Gate::Hold,
                    7 => Gate::Keep,
                    2..=5 if intent == Intent::Drive => Gate::Open,
                    _ => Gate::Brake,
                };
                assert_eq!(Gate::of(state, intent), expected, "{state:?} {intent:?}");
            }
        }
    }

    #[test]
    fn a_gate_that_is_not_open_starts_no_drive_but_one_that_turns_freely() {
        for (enabled, turns_freely) in [(false, false), (true, false), (false, true)] {
            let drive = DriveState {
                enabled,
                turns_freely,
                ..DriveState::default()
            };
            let passed = [Gate::Off, Gate::Hold, Gate::Brake, Gate::Keep, Gate::Open]
                .map(|gate| gate.pass(Goal::Home, &drive));
            let braked = if turns_freely {
                Goal::Velocity(0.0)
            } else {
                Goal::Hold
            };
            let kept = if enabled { Goal::Home } else { braked };
            assert_eq!(passed, [Goal::Off, Goal::Hold, braked, kept, Goal::Home]);
        }
    }
}
