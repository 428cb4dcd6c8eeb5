//! Payload in a scenario, and its conversion for the plant and for the guard's settings.

use crate::bounds::{Problem, within};
use crate::world::load::Load;
use serde::{Deserialize, Serialize};
use tautrack::settings::Setting;

/// Point mass fixed to the robot's body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Payload {
    /// Mass.
    pub mass_kg: f64,
    /// Place in the body's axes (x forward, y left, z up), relative to the origin that the
    /// robot's section defines.
    pub place_m: [f64; 3],
    /// Virtual time from which the load is on board.
    #[serde(default)]
    pub from_s: f64,
    /// Whether the guard's settings contain the load.
    pub declared: bool,
}

impl Payload {
    /// Checks the values; `key` is the path of the table in the scenario file.
    ///
    /// # Errors
    /// [`Problem`] with key, value and bound.
    pub fn check(&self, key: &str, duration_s: f64) -> Result<(), Problem> {
        within(&format!("{key}.mass_kg"), self.mass_kg, 0.0, 50.0, "kg")?;
        for (index, coordinate) in self.place_m.iter().enumerate() {
            within(
                &format!("{key}.place_m[{index}]"),
                *coordinate,
                -1.0,
                1.0,
                "m",
            )?;
        }
        within(&format!("{key}.from_s"), self.from_s, 0.0, duration_s, "s")
    }

    /// Converts the load for the plants.
    pub fn load(&self) -> Load {
        Load {
            mass: self.mass_kg,
            place: self.place_m,
            from_time_s: self.from_s,
        }
    }

    /// Returns the guard's settings for the load; none if the load is not declared.
    pub fn settings(&self) -> Vec<(Setting, i32)> {
        if !self.declared {
            return Vec::new();
        }
        let [forward, left, up] = self.place_m.map(|metres| (metres * 1e6).round() as i32);
        vec![
            (Setting::PayloadMass, (self.mass_kg * 1e3).round() as i32),
            (Setting::PayloadForward, forward),
            (Setting::PayloadLeft, left),
            (Setting::PayloadUp, up),
        ]
    }
}
