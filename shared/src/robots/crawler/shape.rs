//! Defines the crawler's centre of gravity and the corners of its support.

use super::parameters::{Dimensions, Masses, ParametersError, within};

/// Centre of gravity and ends of the runs on the ground, from the middle between the runs: x
/// forward, y left, z up, m.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Shape {
    /// Centre of gravity.
    pub cog: [f32; 3],
    /// Ends of the runs in the middle of each track, counter-clockwise seen from above, starting at
    /// the rear right.
    pub contacts: [[f32; 3]; 4],
}

impl Shape {
    /// Shape of a robot with these dimensions and masses.
    ///
    /// # Errors
    /// The first value out of range: that of the masses, or a contact length or track spacing
    /// outside 1 mm to 10 m.
    pub fn new(dimensions: &Dimensions, body: &Masses) -> Result<Self, ParametersError> {
        const LENGTH: [f64; 2] = [1e-3, 10.0];
        let (_, cog) = body.checked()?;
        let front = 0.5 * within("contact length", dimensions.contact_length, LENGTH)? as f32;
        let left = 0.5 * within("track spacing", dimensions.track_spacing, LENGTH)? as f32;
        Ok(Self {
            cog,
            contacts: [
                [-front, -left, 0.0],
                [front, -left, 0.0],
                [front, left, 0.0],
                [-front, left, 0.0],
            ],
        })
    }

    /// The same shape in level axes; `level` transforms a vector from body axes to level axes.
    #[must_use]
    pub fn turned(&self, level: impl Fn([f32; 3]) -> [f32; 3]) -> Self {
        Self {
            cog: level(self.cog),
            contacts: self.contacts.map(level),
        }
    }
}
