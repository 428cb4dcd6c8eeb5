//! Rates of the sensors on the body.

use crate::bounds::{Problem, within};
use crate::world::sampling::Sampling;
use serde::{Deserialize, Serialize};
use tautrack::settings::Setting;

/// Rates of the sensors on the body, for the plant and for the guard's settings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sensors {
    /// Rate of the inertial unit, Hz.
    pub inertial_hz: i32,
    /// Rate of the inclinometer, Hz.
    pub inclinometer_hz: i32,
}

/// A new reading in each step.
impl Default for Sensors {
    fn default() -> Self {
        Self::at(1_000)
    }
}

impl Sensors {
    /// All sensors at this rate, Hz.
    pub fn at(hz: i32) -> Self {
        Self {
            inertial_hz: hz,
            inclinometer_hz: hz,
        }
    }

    /// Whether every sensor measures in each step.
    pub fn usual(&self) -> bool {
        *self == Self::default()
    }

    /// The inclinometer of a plant, sampled at its rate. The guard sets the rate of its inertial
    /// unit by itself.
    pub fn sampling(&self) -> Sampling {
        Sampling::new(u64::from(self.inclinometer_hz.unsigned_abs()))
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
        Ok(())
    }
}
