//! Section of a scenario file for the crawler: the values that its paper does not give, their
//! bounds, and the parameters of the plant.

use super::nodes;
use super::plant::{self, CrawlerParameters, Profile, Soil as PlantSoil};
use crate::bounds::{Problem, contradiction, within};
use crate::robots::payload::Payload;
use crate::robots::{Conditions, NodeSpec, Posture, Section};
use crate::world::Plant;
use crate::world::terrain::Terrain;
use serde::{Deserialize, Serialize};

/// Values that the paper of Kurc and Szybicki does not give.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Crawler {
    /// Soil in the guard's settings. Cohesion and friction of the simulated soil are these values
    /// times the scenario's `friction`.
    #[serde(default)]
    pub soil: Soil,
    /// Method by which the guard compensates for slip.
    #[serde(default)]
    pub slip_compensation: SlipCompensation,
    /// Acceleration and deceleration over ground.
    #[serde(default = "acceleration")]
    pub acceleration_mps2: f64,
    /// Load in addition to the robot's own mass; its place is relative to the middle between the
    /// tracks, on the ground.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub payload: Option<Payload>,
}

fn acceleration() -> f64 {
    0.4
}

/// Soil with the shear behaviour that Bekker and Kacigin describe.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Soil {
    /// Cohesion.
    pub cohesion_pa: f64,
    /// Angle of internal friction.
    pub friction_deg: f64,
    /// Parameter `K1` of the shear stress.
    pub k1_per_m: f64,
    /// Parameter `K2` of the shear stress.
    pub k2: f64,
}

impl Default for Soil {
    fn default() -> Self {
        let soil = PlantSoil::nominal();
        Self {
            cohesion_pa: soil.cohesion,
            friction_deg: soil.friction_angle.to_degrees(),
            k1_per_m: soil.k1,
            k2: soil.k2,
        }
    }
}

/// Method by which the guard compensates for slip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SlipCompensation {
    /// No compensation.
    None,
    /// Compensation by the model of the soil.
    #[default]
    Soil,
    /// Compensation by the model, corrected with the GNSS receiver's speed.
    Measured,
}

impl Crawler {
    /// Parameters of the plant. The ground has `friction` times the strength in the guard's
    /// settings.
    pub fn parameters(&self, friction: f64) -> CrawlerParameters {
        let soil = PlantSoil {
            cohesion: self.soil.cohesion_pa,
            friction_angle: self.soil.friction_deg.to_radians(),
            k1: self.soil.k1_per_m,
            k2: self.soil.k2,
        };
        CrawlerParameters {
            soil: soil.scaled(friction),
            payload: self.payload.as_ref().map(Payload::load),
            ..CrawlerParameters::nominal()
        }
    }
}

impl Section for Crawler {
    fn check(&self, conditions: &Conditions) -> Result<(), Problem> {
        let Soil {
            cohesion_pa,
            friction_deg,
            k1_per_m,
            k2,
        } = self.soil;
        within(
            "robot.crawler.soil.cohesion_pa",
            cohesion_pa,
            0.0,
            1e6,
            "Pa",
        )?;
        within(
            "robot.crawler.soil.friction_deg",
            friction_deg,
            0.0,
            60.0,
            "deg",
        )?;
        within(
            "robot.crawler.soil.k1_per_m",
            k1_per_m,
            1.0,
            10_000.0,
            "1/m",
        )?;
        within("robot.crawler.soil.k2", k2, 1.0, 100.0, "")?;
        within(
            "robot.crawler.acceleration_mps2",
            self.acceleration_mps2,
            0.01,
            10.0,
            "m/s^2",
        )?;
        if let Some(payload) = &self.payload {
            payload.check("robot.crawler.payload", conditions.duration_s)?;
        }
        if let Terrain::Stairs { .. } | Terrain::Curb { .. } | Terrain::Hillside { .. } =
            conditions.terrain
        {
            return contradiction(
                "terrain",
                "is none of the crawler's plant, which has flat ground, slopes and ramps",
            );
        }
        Ok(())
    }

    fn payload_mut(&mut self) -> Option<&mut Payload> {
        self.payload.as_mut()
    }

    fn front_m(&self) -> f64 {
        0.5 * CrawlerParameters::nominal().extent[0]
    }

    fn posture(&self) -> Posture {
        Posture::None
    }

    fn nodes(&self, conditions: &Conditions) -> Vec<NodeSpec> {
        nodes::nodes(self, conditions)
    }

    fn plant(&self, conditions: &Conditions) -> Box<dyn Plant> {
        let parameters = self.parameters(conditions.friction);
        let ground = conditions.terrain.profile();
        Box::new(plant::Crawler::new(&parameters, &ground, conditions.seed))
    }
}

impl Terrain {
    /// Ground profile for the crawler's plant. A terrain that it cannot represent becomes level
    /// ground.
    pub fn profile(&self) -> Profile {
        match *self {
            Self::Slope {
                angle_deg,
                side_deg,
            } => Profile {
                slope: angle_deg.to_radians(),
                cross: side_deg.to_radians(),
                ..Profile::default()
            },
            Self::Ramp {
                angle_deg,
                foot_m,
                length_m,
            } => Profile {
                slope: angle_deg.to_radians(),
                from_x: Some(foot_m),
                plateau: Some(length_m * libm::sin(angle_deg.to_radians())),
                ..Profile::default()
            },
            Self::Flat | Self::Stairs { .. } | Self::Curb { .. } | Self::Hillside { .. } => {
                Profile::default()
            }
        }
    }
}
