//! Mounting of the guard's sensor board and constant errors of its sensors.

use crate::bounds::{Problem, within};
use crate::world::sensor_board::SensorBoard;
use serde::{Deserialize, Serialize};
use tautrack::constants::GRAVITY_F64;

/// Mounting of the guard's sensor board and constant errors of its sensors, in addition to those of
/// the robot's plant. The guard's settings do not contain them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorErrors {
    /// Rotation of the board from body axes: about x, then y, then z.
    pub mounting_deg: [f64; 3],
    /// Angular rate that the gyroscope shows at rest, in the axes of the board.
    pub rate_at_rest_deg_s: [f64; 3],
    /// Error of the accelerometer, in the axes of the board.
    pub accelerometer_g: [f64; 3],
    /// Field of magnets on the robot in body axes.
    pub hard_iron_ut: [f64; 3],
    /// How much iron on the robot amplifies the field forward and to the left, and how much of each
    /// of the two it turns into the other one.
    pub soft_iron_percent: [f64; 3],
    /// Pitch and roll that the inclinometer shows on a level board.
    pub level_deg: [f64; 2],
}

impl SensorErrors {
    /// The same errors with the gyroscope's and the accelerometer's of `others`, where it has any.
    #[must_use]
    pub fn or(self, others: Self) -> Self {
        let chosen = |own, other| if other == [0.0; 3] { own } else { other };
        Self {
            rate_at_rest_deg_s: chosen(self.rate_at_rest_deg_s, others.rate_at_rest_deg_s),
            accelerometer_g: chosen(self.accelerometer_g, others.accelerometer_g),
            ..self
        }
    }

    /// Returns the board; `None` without errors.
    pub fn board(&self) -> Option<SensorBoard> {
        (*self != Self::default()).then(|| {
            SensorBoard::new(
                self.mounting_deg.map(f64::to_radians),
                self.rate_at_rest_deg_s.map(f64::to_radians),
                self.accelerometer_g.map(|share| share * GRAVITY_F64),
                self.hard_iron_ut,
                self.soft_iron_percent.map(|percent| 0.01 * percent),
                self.level_deg.map(f64::to_radians),
            )
        })
    }

    pub(super) fn check(&self) -> Result<(), Problem> {
        let rows = [
            ("mounting_deg", &self.mounting_deg[..], 180.0, "deg"),
            (
                "rate_at_rest_deg_s",
                &self.rate_at_rest_deg_s,
                20.0,
                "deg/s",
            ),
            ("accelerometer_g", &self.accelerometer_g, 2.0, "g"),
            ("hard_iron_ut", &self.hard_iron_ut, 200.0, "uT"),
            ("soft_iron_percent", &self.soft_iron_percent, 30.0, "%"),
            ("level_deg", &self.level_deg, 20.0, "deg"),
        ];
        for (name, values, most, unit) in rows {
            for (index, value) in values.iter().enumerate() {
                let key = format!("sensors.errors.{name}[{index}]");
                within(&key, *value, -most, most, unit)?;
            }
        }
        Ok(())
    }
}
