//! The cart's section of a scenario: its mast, its acceleration, and their bounds.

use super::{nodes, plant};
use crate::bounds::{Problem, contradiction, within};
use crate::robots::{Conditions, NodeSpec, Posture, Section};
use crate::world::Plant;
use crate::world::terrain::Terrain;
use serde::{Deserialize, Serialize};
use tautrack::robots::cart::parameters::CART;

/// The cart's section of a scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cart {
    /// Height of the head of the mast.
    #[serde(default = "mast")]
    pub mast_m: f64,
    /// Acceleration and deceleration over ground.
    #[serde(default = "acceleration")]
    pub acceleration_mps2: f64,
}

fn mast() -> f64 {
    1.0
}

fn acceleration() -> f64 {
    0.4
}

impl Section for Cart {
    fn check(&self, conditions: &Conditions) -> Result<(), Problem> {
        within("robot.cart.mast_m", self.mast_m, 0.2, 2.0, "m")?;
        within(
            "robot.cart.acceleration_mps2",
            self.acceleration_mps2,
            0.01,
            10.0,
            "m/s^2",
        )?;
        match conditions.terrain {
            Terrain::Flat | Terrain::Slope { .. } => Ok(()),
            _ => contradiction(
                "terrain",
                "is none of the cart's plant, which has flat ground and slopes",
            ),
        }
    }

    fn front_m(&self) -> f64 {
        CART.wheel_radius
    }

    fn posture(&self) -> Posture {
        Posture::None
    }

    fn nodes(&self, conditions: &Conditions) -> Vec<NodeSpec> {
        nodes::nodes(self, conditions)
    }

    fn plant(&self, conditions: &Conditions) -> Box<dyn Plant> {
        let ground = conditions.terrain.ground();
        Box::new(plant::Cart::new(
            self.mast_m,
            conditions.friction,
            &ground,
            conditions.seed,
        ))
    }
}
