//! The parameters of a drive ([`DriveParameters`]), prepared for the tick.

use super::Axle;
use super::homing_method::default_method;
use crate::bus::drive_parameters::DriveParameters;
use crate::bus::scale::Scale;
use crate::constants::CONTROL_PERIOD;
use crate::math::{Turns, saturate};
use crate::motor::profile::Limits;
use crate::settings::{Setting, Settings};

/// Following error time out at start, ms: the dwell of the fault "following error".
const FOLLOWING_TIME: u16 = 100;

/// Ramp of a stop.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Ramp {
    /// With `acceleration_limit`.
    Slow,
    /// With `quick_stop_deceleration`.
    Quick,
}

/// Parameters in force.
#[derive(Clone, Debug)]
pub(super) struct Options {
    pub codes: DriveParameters,
    /// Parameters at start.
    saved: DriveParameters,
    /// Limits of the modes of the profile.
    profile: Limits,
    /// Deceleration of a quick stop, rad/s^2.
    quick_deceleration: f32,
    /// Windows, 2^-32 turn, and their times, ticks.
    pub following: Window,
    pub position: Window,
    /// Change of the torque in one tick, units of torque.
    pub torque_step: f32,
    /// Travel of the settings; `None` if it is not limited.
    travel: Option<(Turns, Turns)>,
}

/// Largest distance between two positions, and the time for which a watch on it must last.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub distance: u64,
    pub ticks: u32,
}

impl Options {
    /// Creates the parameters that follow from the settings. `per_ampere` is the torque in bus
    /// units per A.
    pub fn new(
        settings: &Settings,
        scale: Scale,
        per_ampere: f32,
        travel: Option<(Turns, Turns)>,
    ) -> Self {
        let window = |setting| {
            let distance = Turns::from_radians(settings.si(setting));
            saturate_unsigned(scale.distance_to_bus(distance))
        };
        let end = |position: Turns| saturate(scale.distance_to_bus(position));
        let slope = settings.si(Setting::TorqueModeSlope) * per_ampere;
        let codes = DriveParameters {
            quick_stop: 6,
            shutdown: 0,
            disable_operation: 0,
            halt: 1,
            fault_reaction: 2,
            following_window: window(Setting::FollowingLimit),
            following_time: FOLLOWING_TIME,
            position_window: window(Setting::PositionWindow),
            position_time: settings.get(Setting::PositionWindowTime) as u16,
            position_limits: travel.map_or([0; 2], |(low, high)| [end(low), end(high)]),
            profile_velocity: u32::MAX,
            profile_acceleration: u32::MAX,
            torque_slope: if slope > 1.0 { slope as u32 } else { 1 },
            homing_method: default_method(settings),
        };
        let mut options = Self {
            codes,
            saved: codes,
            profile: Limits::NONE,
            quick_deceleration: quick_deceleration(settings),
            following: Window::OFF,
            position: Window::OFF,
            torque_step: 0.0,
            travel,
        };
        options.prepare(codes, scale);
        options
    }

    /// Takes over the acceleration limit of these settings.
    pub fn retune(&mut self, settings: &Settings) {
        self.quick_deceleration = quick_deceleration(settings);
    }

    /// Puts `codes` in force.
    fn prepare(&mut self, codes: DriveParameters, scale: Scale) {
        self.codes = codes;
        self.following = Window::new(codes.following_window, codes.following_time, scale);
        self.position = Window::new(codes.position_window, codes.position_time, scale);
        self.profile = Limits {
            velocity: scale.profile_from_bus(codes.profile_velocity),
            acceleration: scale.profile_from_bus(codes.profile_acceleration),
        };
        self.torque_step = codes.torque_slope as f32 * CONTROL_PERIOD;
    }

    /// Returns the travel that targets may use: that of the settings, narrowed by the software
    /// position limits.
    fn travel(&self, scale: Scale) -> Option<(Turns, Turns)> {
        let [low, high] = self.codes.position_limits;
        if low >= high {
            return self.travel;
        }
        // The ends of the range replace ends of travel that the bus cannot represent.
        let end = |end: i32| match end {
            i32::MIN => Turns::MIN,
            i32::MAX => Turns::MAX,
            _ => scale.distance_from_bus(i64::from(end)),
        };
        let (low, high) = (end(low), end(high));
        let Some((lowest, highest)) = self.travel else {
            return Some((low, high));
        };
        let within = |position: Turns| {
            if position < lowest {
                lowest
            } else if position > highest {
                highest
            } else {
                position
            }
        };
        Some((within(low), within(high)))
    }

    /// Returns how far homing may move from where it began, 2^-32 turn: the travel of the settings
    /// and a sixteenth of it, because the home switch may be at its end.
    pub fn homing_reach(&self) -> u64 {
        self.travel.map_or(u64::MAX, |(low, high)| {
            let width = (high - low).distance();
            width + width / 16
        })
    }

    /// Returns the limits of the modes of the profile, within `limits`.
    pub fn profile(&self, limits: Limits) -> Limits {
        Limits {
            velocity: limits.velocity.min(self.profile.velocity),
            acceleration: limits.acceleration.min(self.profile.acceleration),
        }
    }

    /// Returns the limits of a stop with this ramp, within `limits`.
    pub fn stop(&self, ramp: Ramp, limits: Limits) -> Limits {
        Limits {
            acceleration: match ramp {
                Ramp::Slow => limits.acceleration,
                Ramp::Quick => self.quick_deceleration,
            },
            ..limits
        }
    }
}

fn quick_deceleration(settings: &Settings) -> f32 {
    settings.si_or(Setting::QuickStopDeceleration, Setting::AccelerationLimit)
}

impl Window {
    const OFF: Self = Self {
        distance: u64::MAX,
        ticks: 0,
    };

    fn new(distance: u32, milliseconds: u16, scale: Scale) -> Self {
        Self {
            distance: if distance == u32::MAX {
                u64::MAX
            } else {
                scale.distance_from_bus(i64::from(distance)).distance()
            },
            ticks: u32::from(milliseconds),
        }
    }
}

/// Converts a distance to an object of 32 bits without sign.
fn saturate_unsigned(distance: i64) -> u32 {
    let distance = distance.unsigned_abs();
    if distance < u64::from(u32::MAX) {
        distance as u32
    } else {
        u32::MAX
    }
}

impl Axle {
    /// Returns the parameters in force. At start they follow from the settings.
    pub fn parameters(&self) -> DriveParameters {
        self.options.codes
    }

    /// Puts the parameters at start in force again. What a client has written before its guard
    /// began does not count for the guard.
    pub(super) fn forget_client(&mut self) {
        let saved = self.options.saved;
        self.configure(&saved);
    }

    /// Puts parameters in force that a client has written.
    pub fn configure(&mut self, parameters: &DriveParameters) {
        self.options.prepare(*parameters, self.scale);
        self.travel = self.options.travel(self.scale);
        self.homing.code = parameters.homing_method;
    }
}
