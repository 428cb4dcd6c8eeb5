//! Collects the pictures of the 3-D scene.

use crate::results::scene::pack::{packed, round};
use crate::results::scene::{ground, still};
use crate::scenario::Scenario;
use crate::simulator::record::Sample;
use crate::world::Plant;
use serde_json::json;

/// Maximum number of pictures.
const MOST: usize = 1_000;
/// Distance by which the ground extends beyond the robot's path, m.
const AROUND: f64 = 2.5;
/// Minimum edge length of the ground's cells, m, and maximum number of them along each axis.
const CELL: f64 = 0.1;
const MOST_CELLS: f64 = 120.0;

/// The pictures of a run that goes on: one of every `every` samples.
pub(super) struct Pictures {
    /// As JSON, which takes less memory.
    states: Vec<String>,
    every: usize,
    samples: usize,
    /// Minimum and maximum of x, then of y, of the robot's path, m.
    area: [[f64; 2]; 2],
}

impl Default for Pictures {
    fn default() -> Self {
        Self {
            states: Vec::new(),
            every: 1,
            samples: 0,
            area: [[f64::INFINITY, f64::NEG_INFINITY]; 2],
        }
    }
}

impl Pictures {
    /// Adds the next sample.
    pub fn add(&mut self, sample: &Sample) {
        for ([from, to], place) in self.area.iter_mut().zip(sample.truth.cog) {
            (*from, *to) = (from.min(place), to.max(place));
        }
        if self.samples.is_multiple_of(self.every) {
            if self.states.len() == MOST {
                let mut keep = [true, false].into_iter().cycle();
                self.states.retain(|_| keep.next() == Some(true));
                self.every *= 2;
            }
            self.states.push(state(sample));
        }
        self.samples += 1;
    }

    /// Packs ground, shapes and pictures; empty if there is no picture.
    pub fn pack(&self, scenario: &Scenario, plant: &dyn Plant) -> String {
        if self.states.is_empty() {
            return String::new();
        }
        let area = self.area.map(|[from, to]| [from - AROUND, to + AROUND]);
        let longest = area.iter().map(|[from, to]| to - from);
        let cell = longest.fold(0.0, f64::max) / MOST_CELLS;
        let data = format!(
            r#"{{"still":{},"ground":{},"states":[{}]}}"#,
            still(scenario, plant),
            ground(plant, area, cell.max(CELL)),
            self.states.join(",")
        );
        packed(data.as_bytes())
    }
}

/// What the scene shows of a sample.
fn state(sample: &Sample) -> String {
    let Sample {
        time_s,
        truth,
        received,
        bodies,
        belts,
        ..
    } = sample;
    let mut state = json!({ "forces": [], "sample": {
        "time_s": time_s, "bodies": bodies, "belts": belts,
        "received": { "margins": received.margins },
        "truth": {
            "axle_1": truth.axle_1, "cog": truth.cog, "yaw": truth.yaw,
            "contacts": truth.contacts, "belt_speed": truth.belt_speed, "points": truth.points,
        },
    } });
    round(&mut state);
    state.to_string()
}
