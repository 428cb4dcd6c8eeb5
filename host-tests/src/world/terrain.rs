//! Terrain of a scenario: its values, their bounds, and the ground built from them.

use super::ground::{Ground, Stairs};
use crate::bounds::{Problem, within};
use serde::{Deserialize, Serialize};

/// Terrain of a scenario; level ground by default.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Terrain {
    /// Level ground of unlimited extent.
    Flat,
    /// Stairs up to a landing.
    Stairs {
        /// Height of one step.
        riser_m: f64,
        /// Depth of one step.
        run_m: f64,
        /// Number of risers; the last leads onto the landing.
        count: u32,
        /// Width of the stairs, centred on y = 0.
        width_m: f64,
        /// x of the first nose.
        first_nose_m: f64,
        /// Length of the landing.
        #[serde(default = "landing")]
        landing_m: f64,
        /// Whether the robot starts on the landing and the stairs lead down.
        #[serde(default)]
        down: bool,
    },
    /// One step up and, behind it, one step down.
    Curb {
        /// Height.
        height_m: f64,
        /// x of the nose (front edge).
        nose_m: f64,
        /// Length along x.
        #[serde(default = "landing")]
        depth_m: f64,
    },
    /// Level ground, a ramp up, and a plateau.
    Ramp {
        /// Rise.
        angle_deg: f64,
        /// x of the ramp's foot.
        foot_m: f64,
        /// Length of the ramp along its face.
        length_m: f64,
    },
    /// Hill that rises to the left, with waves on all of it; only Hylos can drive on it. The robot
    /// starts on the level ground before it.
    Hillside {
        /// Rise along y.
        slope_deg: f64,
        /// y of the middle of the hill's foot.
        foot_m: f64,
        /// Half the height between crest and trough of the waves.
        #[serde(default)]
        wave_height_m: f64,
    },
    /// Plane of unlimited extent, on which the robot starts.
    Slope {
        /// Rise along x.
        angle_deg: f64,
        /// Rise to the left.
        #[serde(default)]
        side_deg: f64,
    },
}

fn landing() -> f64 {
    6.0
}

impl Terrain {
    /// Ground for all plants except those of the crawler and Hylos.
    pub fn ground(&self) -> Ground {
        match *self {
            // Only Hylos' plant has hillsides.
            Self::Flat | Self::Hillside { .. } => Ground::Flat,
            Self::Stairs {
                riser_m,
                run_m,
                count,
                width_m,
                first_nose_m,
                landing_m,
                down,
            } => Ground::Stairs(Stairs {
                riser: riser_m,
                run: run_m,
                count: count as usize,
                width: width_m,
                first_nose_x: first_nose_m,
                landing: landing_m,
                down,
            }),
            Self::Curb {
                height_m,
                nose_m,
                depth_m,
            } => Ground::Curb {
                height: height_m,
                front_x: nose_m,
                depth: depth_m,
            },
            Self::Ramp {
                angle_deg,
                foot_m,
                length_m,
            } => Ground::Ramp {
                pitch: angle_deg.to_radians(),
                foot_x: foot_m,
                length: length_m,
            },
            Self::Slope {
                angle_deg,
                side_deg,
            } => Ground::Incline {
                pitch: angle_deg.to_radians(),
                roll: side_deg.to_radians(),
            },
        }
    }

    /// x of the last nose, behind which the landing lies (or the ground, if the stairs lead down);
    /// `None` for terrains without noses.
    pub fn last_nose_m(&self) -> Option<f64> {
        match self.ground() {
            Ground::Stairs(stairs) => Some(stairs.last_nose_x()),
            Ground::Curb { front_x, .. } => Some(front_x),
            Ground::Flat | Ground::Ramp { .. } | Ground::Incline { .. } => None,
        }
    }
}

impl Terrain {
    /// Checks the values. `front_m` is the position of the robot's foremost point at the start.
    ///
    /// # Errors
    /// [`Problem`] with key, value and bound.
    pub fn check(&self, front_m: f64) -> Result<(), Problem> {
        let ahead = |key: &str, x: f64| {
            let unit = "m (the minimum is where the robot's front stands at the start)";
            within(key, x, front_m, 50.0, unit)
        };
        match *self {
            Self::Flat => Ok(()),
            Self::Stairs {
                riser_m,
                run_m,
                count,
                width_m,
                first_nose_m,
                landing_m,
                down: _,
            } => {
                within("terrain.stairs.riser_m", riser_m, 0.01, 0.5, "m")?;
                within("terrain.stairs.run_m", run_m, 0.05, 2.0, "m")?;
                within("terrain.stairs.count", f64::from(count), 1.0, 20.0, "")?;
                within("terrain.stairs.width_m", width_m, 0.8, 20.0, "m")?;
                within("terrain.stairs.landing_m", landing_m, 0.5, 50.0, "m")?;
                ahead("terrain.stairs.first_nose_m", first_nose_m)
            }
            Self::Curb {
                height_m,
                nose_m,
                depth_m,
            } => {
                within("terrain.curb.height_m", height_m, 0.01, 0.5, "m")?;
                within("terrain.curb.depth_m", depth_m, 0.05, 50.0, "m")?;
                ahead("terrain.curb.nose_m", nose_m)
            }
            Self::Ramp {
                angle_deg,
                foot_m,
                length_m,
            } => {
                within("terrain.ramp.angle_deg", angle_deg, 0.0, 75.0, "deg")?;
                within("terrain.ramp.length_m", length_m, 0.1, 50.0, "m")?;
                ahead("terrain.ramp.foot_m", foot_m)
            }
            Self::Hillside {
                slope_deg,
                foot_m,
                wave_height_m,
            } => {
                within("terrain.hillside.slope_deg", slope_deg, 0.0, 60.0, "deg")?;
                within("terrain.hillside.foot_m", foot_m, 1.0, 6.0, "m")?;
                within(
                    "terrain.hillside.wave_height_m",
                    wave_height_m,
                    0.0,
                    0.1,
                    "m",
                )
            }
            Self::Slope {
                angle_deg,
                side_deg,
            } => {
                within("terrain.slope.angle_deg", angle_deg, -75.0, 75.0, "deg")?;
                within("terrain.slope.side_deg", side_deg, -75.0, 75.0, "deg")
            }
        }
    }
}
