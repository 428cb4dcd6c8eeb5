//! Settings that take effect at once ([`Effect`]): what a drive accepts, by what it does now.

use crate::bus::node::Abort;
use crate::motor::board_limits;
use crate::motor::bridge::Ratings;
use crate::motor::calibration;
use crate::motor::current::largest_current;
use crate::node::axle::{BridgeDemand, Inputs, Outputs};
use crate::settings::{Effect, Setting, Settings};

/// Currents and speeds per unit of their settings, mA and mrad/s.
const UNIT: f32 = 1e-3;

/// What a drive does since its last tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tuning {
    /// Largest current limit that the board can measure, and largest velocity limit with
    /// which it bears an open bridge, in the units of the settings.
    largest_current: i32,
    largest_velocity: i32,
    /// The motor has current.
    pub armed: bool,
    /// A calibration excites the motor, within the limits with which it began.
    calibrates: bool,
    /// Demanded or measured current, whichever is larger, A, and speed, rad/s.
    current: f32,
    speed: f32,
}

impl Tuning {
    /// Creates the state of a drive that is off.
    pub fn new(settings: &Settings, ratings: &Ratings) -> Self {
        let mut tuning = Self {
            largest_current: 0,
            largest_velocity: 0,
            armed: false,
            calibrates: false,
            current: 0.0,
            speed: 0.0,
        };
        tuning.fit(settings, ratings);
        tuning
    }

    /// Takes what a calibration has changed in the settings.
    pub fn fit(&mut self, settings: &Settings, ratings: &Ratings) {
        let current = largest_current(&calibration::sensing(settings), ratings);
        let velocity = board_limits::largest_velocity(settings, ratings.highest_supply);
        self.largest_current = (current / UNIT) as i32;
        self.largest_velocity = (velocity / UNIT) as i32;
    }

    /// Takes inputs and outputs of a tick.
    pub fn update(&mut self, inputs: &Inputs, outputs: &Outputs, calibrates: bool) {
        self.armed = calibrates || outputs.bridge != BridgeDemand::Off;
        self.calibrates = calibrates;
        let demanded = match outputs.bridge {
            BridgeDemand::Current(current) | BridgeDemand::Align { current, .. } => current.abs(),
            BridgeDemand::Braking { current, direct } => current.abs() + direct.abs(),
            BridgeDemand::Off | BridgeDemand::Brake | BridgeDemand::Aligned(_) => 0.0,
        };
        let measured = inputs.current.abs();
        // NaN as the measured current stays: then nothing is known.
        self.current = if demanded > measured {
            demanded
        } else {
            measured
        };
        self.speed = outputs.velocity.abs();
    }

    /// Checks a new `value` of a setting whose value is `before`. Returns whether it takes effect
    /// at once. A value out of bounds does not; it is refused elsewhere. A speed at which the board
    /// does not bear an open bridge waits for the next start.
    ///
    /// # Errors
    /// [`Abort::TooHigh`] if the board cannot measure the current. [`Abort::DeviceState`] while a
    /// calibration runs, and if an armed drive would get a higher limit, one below its present
    /// current or speed (that would be a fault at once), or another limit of its deceleration,
    /// power or slope ([`Effect::Disarmed`]).
    pub fn check(&self, setting: Setting, before: i32, value: i32) -> Result<bool, Abort> {
        let effect = setting.effect();
        let row = setting.bounds();
        if effect == Effect::Restart || value < row.minimum || value > row.maximum {
            return Ok(false);
        }
        if setting == Setting::CurrentLimit && value > self.largest_current {
            return Err(Abort::TooHigh);
        }
        let present = match setting {
            Setting::CurrentLimit | Setting::BenchCurrent => self.current,
            Setting::VelocityLimit | Setting::BenchSpeed => self.speed,
            _ => 0.0,
        };
        let allowed = match effect {
            _ if !self.armed => true,
            Effect::Gain => true,
            Effect::Limit => {
                !self.waits(setting, before) && value <= before && present <= value as f32 * UNIT
            }
            Effect::Disarmed | Effect::Restart => false,
        };
        if self.calibrates || !allowed {
            return Err(Abort::DeviceState);
        }
        Ok(!self.waits(setting, value))
    }

    /// Returns whether a value waits for the next start: at this speed of the present motor the
    /// board does not bear an open bridge. It may fit the motor that is written next. A save and
    /// the next start check both.
    pub fn waits(&self, setting: Setting, value: i32) -> bool {
        setting == Setting::VelocityLimit && value > self.largest_velocity
    }
}
