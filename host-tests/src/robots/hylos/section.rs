//! Section of a scenario file for Hylos: how it is driven, the bounds of the values, and the
//! parameters of the plant.

use super::nodes;
use super::plant::{self, Hillside, HylosParameters};
use crate::bounds::{Problem, contradiction, within};
use crate::robots::{Conditions, NodeSpec, Posture, Section};
use crate::world::Plant;
use crate::world::terrain::Terrain;
use serde::{Deserialize, Serialize};
use tautrack::robots::hylos::parameters::STANCE_HEIGHT;

/// Half the side of the square that the ground covers, m, and the minimum of its y, m.
const EXTENT: f64 = 6.0;
const NEAREST_Y: f64 = -4.0;
/// Distance from crest to crest of the waves along x and along y, m.
const WAVE_LENGTH: [f64; 2] = [1.1, 1.3];

/// Properties of Hylos that a scenario may change.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hylos {
    /// Whether the legs move the body away from where it would tip over.
    #[serde(default = "on")]
    pub posture_control: bool,
    /// Height of the hips above the wheels' centres that the operator commands.
    #[serde(default = "clearance")]
    pub clearance_m: f64,
    /// Acceleration and deceleration over ground.
    #[serde(default = "acceleration")]
    pub acceleration_mps2: f64,
    /// Heading at the start, counter-clockwise from the x axis.
    #[serde(default)]
    pub heading_deg: f64,
}

fn on() -> bool {
    true
}

fn clearance() -> f64 {
    STANCE_HEIGHT
}

fn acceleration() -> f64 {
    0.4
}

impl Hylos {
    /// Parameters of the plant, on ground with this coefficient of friction.
    pub fn parameters(&self, friction: f64) -> HylosParameters {
        HylosParameters {
            friction,
            ..HylosParameters::nominal([0.0, 0.0, self.heading_deg.to_radians()])
        }
    }
}

impl Section for Hylos {
    fn check(&self, conditions: &Conditions) -> Result<(), Problem> {
        let bounds = [
            ("robot.hylos.clearance_m", self.clearance_m, 0.1, 0.4, "m"),
            (
                "robot.hylos.acceleration_mps2",
                self.acceleration_mps2,
                0.01,
                10.0,
                "m/s^2",
            ),
            (
                "robot.hylos.heading_deg",
                self.heading_deg,
                -180.0,
                180.0,
                "deg",
            ),
        ];
        for (key, value, least, most, unit) in bounds {
            within(key, value, least, most, unit)?;
        }
        match conditions.terrain {
            Terrain::Flat | Terrain::Hillside { .. } => Ok(()),
            _ => contradiction(
                "terrain",
                "is none of Hylos' plant, which has flat ground and hillsides",
            ),
        }
    }

    fn front_m(&self) -> f64 {
        // Hylos' grounds have no edges ahead.
        0.0
    }

    fn posture(&self) -> Posture {
        Posture::Clearance {
            first_m: self.clearance_m,
        }
    }

    fn extent(&self, terrain: &Terrain) -> Option<[[f64; 2]; 2]> {
        Some(terrain.hillside().extent)
    }

    fn nodes(&self, conditions: &Conditions) -> Vec<NodeSpec> {
        nodes::nodes(self, conditions)
    }

    fn plant(&self, conditions: &Conditions) -> Box<dyn Plant> {
        let parameters = self.parameters(conditions.friction);
        let ground = conditions.terrain.hillside();
        Box::new(plant::Hylos::new(&parameters, &ground, conditions.seed))
    }
}

impl Terrain {
    /// Ground for Hylos' plant. A terrain that it cannot represent becomes level ground.
    pub fn hillside(&self) -> Hillside {
        let [slope, foot_y, wave_height] = match *self {
            Self::Hillside {
                slope_deg,
                foot_m,
                wave_height_m,
            } => [slope_deg.to_radians(), foot_m, wave_height_m],
            _ => [0.0; 3],
        };
        Hillside {
            slope,
            foot_y,
            wave_height,
            wave_length: WAVE_LENGTH,
            extent: [[-EXTENT, EXTENT], [NEAREST_Y, NEAREST_Y + 2.0 * EXTENT]],
        }
    }
}
