//! Rates of the sensors on the body, and their constant errors.

use super::SensorErrors;
use crate::bounds::{Problem, within};
use serde::{Deserialize, Serialize};
use tautrack::settings::Setting;

/// Rates of the sensors on the body, which the guard gets as its settings, and errors of the
/// sensors, for the plant alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sensors {
    /// Rate of the inertial unit, Hz.
    pub inertial_hz: i32,
    /// Rate of the inclinometer, Hz.
    pub inclinometer_hz: i32,
    /// Mounting of the board and constant errors of the sensors.
    pub errors: SensorErrors,
}

/// A new reading of the inertial unit in each step.
impl Default for Sensors {
    fn default() -> Self {
        Self {
            inclinometer_hz: 100,
            ..Self::at(1_000)
        }
    }
}

impl Sensors {
    /// All sensors at this rate, Hz.
    pub fn at(hz: i32) -> Self {
        Self {
            inertial_hz: hz,
            inclinometer_hz: hz,
            errors: SensorErrors::default(),
        }
    }

    /// Whether these are the rates in the settings' defaults, and the sensors have no errors.
    pub fn usual(&self) -> bool {
        *self == Self::default()
    }

    /// Settings of the guard that tell it these rates.
    pub fn settings(&self) -> [(Setting, i32); 2] {
        [
            (Setting::InertialRate, self.inertial_hz),
            (Setting::InclinometerRate, self.inclinometer_hz),
        ]
    }

    /// Checks that the guard has settings for these rates.
    pub(super) fn check(self) -> Result<(), Problem> {
        let keys = ["sensors.inertial_hz", "sensors.inclinometer_hz"];
        for (key, (setting, value)) in keys.into_iter().zip(self.settings()) {
            let row = setting.description();
            let (low, high) = (f64::from(row.minimum), f64::from(row.maximum));
            within(key, f64::from(value), low, high, "Hz")?;
        }
        self.errors.check()
    }
}
