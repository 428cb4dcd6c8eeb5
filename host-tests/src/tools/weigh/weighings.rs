//! The file with the readings of the scales.

use super::WeighError;
use serde::Deserialize;
use std::fs;
use std::ops::RangeInclusive;
use std::path::Path;

/// Readings of the scales at several postures of the robot.
#[derive(Deserialize, Clone, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct Weighings {
    /// Standard deviation of one reading, kg.
    pub scale_error_kg: f64,
    /// Standard deviation of the pitch, degrees.
    pub pitch_error_degrees: f64,
    /// Standard deviation of the chassis angle, degrees.
    pub joint_error_degrees: f64,
    pub weighing: Vec<Weighing>,
}

/// Readings at one posture, kg. Two of the axles stand on scales.
#[derive(Deserialize, Clone, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct Weighing {
    /// Chassis angle, front up.
    pub joint_degrees: f64,
    /// Pitch of body 1, nose up.
    pub pitch_degrees: f64,
    pub axle_1_kg: Option<Reading>,
    pub axle_2_kg: Option<Reading>,
    pub axle_3_kg: Option<Reading>,
}

/// What the scales under one axle show.
#[derive(Deserialize, Clone, Copy, Debug)]
#[serde(untagged)]
pub(super) enum Reading {
    /// One scale under the whole axle.
    Axle(f64),
    /// Scales under its left and its right end.
    Sides([f64; 2]),
}

impl Reading {
    pub fn sum(self) -> f64 {
        match self {
            Self::Axle(whole) => whole,
            Self::Sides([left, right]) => left + right,
        }
    }

    /// Number of scales.
    pub fn scales(self) -> f64 {
        match self {
            Self::Axle(_) => 1.0,
            Self::Sides(_) => 2.0,
        }
    }

    /// How much more the left scale shows, if there are two.
    pub fn left_excess(self) -> Option<f64> {
        match self {
            Self::Axle(_) => None,
            Self::Sides([left, right]) => Some(left - right),
        }
    }

    fn values(self) -> Vec<f64> {
        match self {
            Self::Axle(whole) => vec![whole],
            Self::Sides(sides) => sides.to_vec(),
        }
    }
}

impl Weighings {
    /// # Errors
    /// [`WeighError::File`], with the value and its bounds.
    pub fn read(path: &Path) -> Result<Self, WeighError> {
        let refuse = |why: String| WeighError::File(path.to_owned(), why);
        let text = fs::read_to_string(path).map_err(|error| refuse(error.to_string()))?;
        let read: Self = toml::from_str(&text).map_err(|error| refuse(error.to_string()))?;
        read.check().map_err(refuse)?;
        Ok(read)
    }

    fn check(&self) -> Result<(), String> {
        within("scale_error_kg", self.scale_error_kg, 1e-4..=10.0)?;
        within("pitch_error_degrees", self.pitch_error_degrees, 0.0..=10.0)?;
        within("joint_error_degrees", self.joint_error_degrees, 0.0..=10.0)?;
        if self.weighing.is_empty() {
            return Err("no [[weighing]]".to_owned());
        }
        for (index, weighing) in self.weighing.iter().enumerate() {
            let check = || {
                within("joint_degrees", weighing.joint_degrees, -120.0..=120.0)?;
                within("pitch_degrees", weighing.pitch_degrees, -60.0..=60.0)?;
                let [(_, first), (_, second)] = weighing.axles()?;
                for value in first.values().into_iter().chain(second.values()) {
                    within("a reading in kg", value, 0.0..=500.0)?;
                }
                if first.left_excess().is_some() != second.left_excess().is_some() {
                    return Err("one axle has two scales and the other one".to_owned());
                }
                Ok(())
            };
            check().map_err(|why: String| format!("weighing {}: {why}", index + 1))?;
        }
        Ok(())
    }
}

impl Weighing {
    /// The two axles on scales, each by its number, with its reading.
    ///
    /// # Errors
    /// If there are not two.
    pub fn axles(&self) -> Result<[(usize, Reading); 2], String> {
        let all = [self.axle_1_kg, self.axle_2_kg, self.axle_3_kg];
        let read = (1..).zip(all);
        let read: Vec<_> = read
            .filter_map(|(axle, reading)| Some((axle, reading?)))
            .collect();
        let count = read.len();
        read.try_into().map_err(|_| {
            format!(
                "{count} axles have readings; two must stand on scales and the third in the air"
            )
        })
    }
}

fn within(name: &str, value: f64, bounds: RangeInclusive<f64>) -> Result<(), String> {
    if bounds.contains(&value) {
        return Ok(());
    }
    let (minimum, maximum) = (bounds.start(), bounds.end());
    Err(format!("{name} = {value}: allowed {minimum} to {maximum}"))
}
