//! A load in a scenario, as the plant takes it, and as the guard is told of it.

use crate::bounds::{Problem, within};
use crate::world::load::Load;
use serde::{Deserialize, Serialize};
use tautrack::settings::Setting;

/// A point mass fixed to the robot's body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Payload {
    /// Mass.
    pub mass_kg: f64,
    /// Place in the body's axes, x forward, y left, z up: from axle 1 of B2P2; the other robots' sections name their origins.
    pub place_m: [f64; 3],
    /// Virtual time from which it is on board.
    #[serde(default)]
    pub from_s: f64,
    /// Whether the guard's settings know of it.
    pub declared: bool,
}

impl Payload {
    /// Checks its values; `key` is the path of its table.
    ///
    /// # Errors
    /// Names key, value and bound.
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

    /// As the plants take it.
    pub fn load(&self) -> Load {
        Load {
            mass: self.mass_kg,
            place: self.place_m,
            from_time_s: self.from_s,
        }
    }

    /// What the guard is told of it: nothing of a load that is not declared.
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
