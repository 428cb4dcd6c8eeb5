//! What a calibration is allowed to do, and what it must know beforehand.

use crate::constants::CONTROL_PERIOD;
use crate::motor::bridge::Ratings;
use crate::motor::current::MotorKind;
use crate::motor::rotor::RotorSensor;
use crate::settings::{Setting, Settings};

/// Control periods per second.
pub(super) const CONTROL_HZ: u32 = (1.0 / CONTROL_PERIOD + 0.5) as u32;

/// Bounds and known values of a calibration.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Plan {
    /// Kind of the motor.
    pub kind: MotorKind,
    /// Power stage of the board.
    pub ratings: Ratings,
    /// Counts of the rotor sensor per turn of the rotor.
    pub counts_per_turn: i32,
    /// Rotor turns per turn of the output shaft.
    pub gear_ratio: f32,
    /// Largest current, A.
    pub current: f32,
    /// Largest speed of the rotor, rad/s.
    pub speed: f32,
    /// Largest distance from the position at the start while the torque constant is not measured,
    /// turns of the rotor.
    pub travel: f32,
    /// Torque constant in the settings, N m/A. The resistance of a brushed motor whose shaft is not
    /// free is measured with it.
    pub torque_constant: f32,
    /// The sensor has an index, at whose pulse the electrical offset counts.
    pub index: bool,
    /// The shaft is free to turn, as far as it likes: the torque constant is measured too.
    pub free_shaft: bool,
}

impl Plan {
    /// Reads the plan from the settings.
    pub fn from_settings(settings: &Settings, ratings: &Ratings, free_shaft: bool) -> Self {
        let gear_ratio = settings.scaled(Setting::GearRatio, 1e-3);
        let current = settings.scaled(Setting::CalibrationCurrent, 1e-3);
        let travel = settings.scaled(Setting::CalibrationTravel, 1e-3);
        Self {
            kind: if settings.get(Setting::MotorKind) == 0 {
                MotorKind::Brushed
            } else {
                MotorKind::ThreePhase
            },
            ratings: *ratings,
            counts_per_turn: settings.get(Setting::EncoderCounts),
            gear_ratio,
            current: crate::math::limit(current, settings.scaled(Setting::CurrentLimit, 1e-3)),
            speed: settings.scaled(Setting::CalibrationSpeed, 1e-3) * gear_ratio,
            travel: travel * gear_ratio / core::f32::consts::TAU,
            torque_constant: settings.scaled(Setting::TorqueConstant, 1e-6),
            index: RotorSensor::of(settings) == Some(RotorSensor::Indexed),
            free_shaft,
        }
    }

    /// Converts counts to turns of the rotor.
    pub(super) fn turns(&self, counts: i64) -> f32 {
        counts as f32 / self.counts_per_turn as f32
    }

    /// PWM periods per control period.
    pub fn periods_per_control(&self) -> u32 {
        self.ratings.pwm_hz / CONTROL_HZ
    }
}
