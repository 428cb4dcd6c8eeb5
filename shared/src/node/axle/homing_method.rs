//! Homing methods of CiA 402 (object 0x6098): which switch, and which of its edges, is the home
//! position.

use crate::sensors::Switches;
use crate::settings::{Setting, Settings};

/// Switch that homing looks for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Switch {
    Home,
    PositiveLimit,
    NegativeLimit,
}

/// A homing method that moves: the axle moves in `direction` until its signal becomes true there.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Method {
    switch: Switch,
    /// 1, or -1; 0 for an axle that needs no homing.
    pub direction: i8,
    /// The home position is where the switch opens. The signal is then the inverse of the switch.
    pub opens: bool,
    /// The axle turns round at the positive limit switch.
    reverses: bool,
}

/// No homing method.
pub(super) const NO_METHOD: i8 = 0;
/// Homing method that takes the present position as the home position.
pub(super) const PRESENT_POSITION: i8 = 37;

/// Returns the homing method that `homing_direction` selects: 20 or 22; 0 for an axle that needs no
/// homing.
pub(super) fn default_method(settings: &Settings) -> i8 {
    match settings.get(Setting::HomingDirection) {
        1 => 20,
        -1 => 22,
        _ => NO_METHOD,
    }
}

impl Method {
    /// Returns the method with this code. A code without a method does not move the axle.
    pub fn of(code: i8) -> Self {
        let (switch, direction, opens) = match code {
            17 => (Switch::NegativeLimit, 1, true),
            18 => (Switch::PositiveLimit, -1, true),
            19 | 23 => (Switch::Home, -1, true),
            20 | 24 => (Switch::Home, 1, false),
            21 => (Switch::Home, 1, true),
            22 => (Switch::Home, -1, false),
            _ => (Switch::Home, 0, false),
        };
        Self {
            switch,
            direction,
            opens,
            reverses: matches!(code, 23 | 24),
        }
    }

    /// Returns the signal of the method's switch.
    pub fn signal(self, switches: Switches) -> bool {
        let closed = match self.switch {
            Switch::Home => switches.home,
            Switch::PositiveLimit => switches.positive_limit,
            Switch::NegativeLimit => switches.negative_limit,
        };
        closed != self.opens
    }

    /// Returns whether an axle that moves with `velocity` to look for its switch must turn round.
    pub fn turns_round(self, switches: Switches, velocity: f32) -> bool {
        self.reverses && switches.positive_limit && velocity > 0.0
    }
}
