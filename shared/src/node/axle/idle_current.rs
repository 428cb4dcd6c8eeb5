//! Checks the zero of the current converters at each arming. While the bridge is open and the shaft
//! stands, no current flows. A converter that shows one would give the motor a wrong torque, or
//! hide an over-current.

use crate::motor::current::Electrical;

/// Mean current that counts, as a fraction of the current limit. A smaller one, from 1 % on, can
/// still make a three-phase drive look as if its rotor angle were wrong.
const WRONG: f32 = 0.02;
/// Control periods in succession for which it must last. Currents that a shaft makes while it stops
/// are gone by then.
const PERIODS: u8 = 20;

/// What the converters show while the bridge is open.
#[derive(Clone, Debug)]
pub(super) struct IdleCurrent {
    /// A.
    bound: f32,
    periods: u8,
}

impl IdleCurrent {
    /// Creates the check of a drive with this current limit, A.
    pub fn new(current_limit: f32) -> Self {
        Self {
            bound: WRONG * current_limit,
            periods: 0,
        }
    }

    /// Takes [`Electrical::idle`] of a control period.
    pub fn update(&mut self, electrical: &Electrical, stands: bool) {
        let Some(idle) = electrical.idle else {
            return;
        };
        // NaN counts as wrong.
        let wrong = idle.iter().any(|current| !(*current <= self.bound));
        self.periods = if wrong && stands {
            self.periods.saturating_add(1)
        } else {
            0
        };
    }

    /// Returns whether a converter showed a current when the bridge was open last.
    pub fn is_wrong(&self) -> bool {
        self.periods >= PERIODS
    }
}
