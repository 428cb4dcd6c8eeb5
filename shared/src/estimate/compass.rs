//! Computes the heading from a three-axis magnetometer on a tilted body.

use crate::estimate::attitude::LevelAxes;
use crate::math::sqrt;
use crate::settings::{Setting, Settings};
use crate::units::Angle;
use micromath::F32;

/// Range of the earth's field strength near its surface, with a tolerance for a poor calibration,
/// uT.
pub const STRENGTH: [f32; 2] = [15.0, 90.0];
/// Minimum horizontal fraction of the field. It corresponds to an inclination of 80 degrees. Beyond
/// it, one degree of tilt turns the heading by six degrees.
pub const HORIZONTAL_SHARE: f32 = 0.174;

/// Reason why a reading gives no heading.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum CompassError {
    /// A component is NaN or infinite.
    NotFinite,
    /// The field, without the hard iron, is weaker or stronger than the earth's. The value is its
    /// strength, uT.
    Strength(f32),
    /// The horizontal fraction of the field is below [`HORIZONTAL_SHARE`]. The value is this
    /// fraction.
    Steep(f32),
}

/// A compass with its calibration.
#[derive(Clone, Copy, Debug)]
pub struct Compass {
    hard_iron: [f32; 3],
    /// Symmetric matrix that corrects the horizontal components: xx, yy, xy.
    soft_iron: [f32; 3],
    declination: Angle,
}

/// A compass without iron around it, where magnetic north is true north.
impl Default for Compass {
    fn default() -> Self {
        Self::new([0.0; 3], Angle::ZERO)
    }
}

impl Compass {
    /// Creates a compass that subtracts `hard_iron`, the field of the robot's own magnets in body
    /// axes, uT. Magnetic north lies east of true north by `declination`.
    pub fn new(hard_iron: [f32; 3], declination: Angle) -> Self {
        Self {
            hard_iron,
            soft_iron: [1.0, 1.0, 0.0],
            declination,
        }
    }

    /// The compass with this correction for soft iron: a symmetric matrix (xx, yy, xy) for the
    /// horizontal components in body axes.
    #[must_use]
    pub fn with_soft_iron(self, soft_iron: [f32; 3]) -> Self {
        Self { soft_iron, ..self }
    }

    /// Creates a compass with the calibration in the settings.
    pub fn with_settings(settings: &Settings) -> Self {
        Self::new(
            [
                settings.si(Setting::HardIronForward),
                settings.si(Setting::HardIronLeft),
                settings.si(Setting::HardIronUp),
            ],
            Angle::from_degrees(settings.si(Setting::Declination)),
        )
        .with_soft_iron(
            [
                Setting::SoftIronForward,
                Setting::SoftIronLeft,
                Setting::SoftIronCross,
            ]
            .map(|setting| settings.si(setting)),
        )
    }

    /// Returns q4 of Paillat et al.: the heading from true north, counter-clockwise seen from
    /// above.
    ///
    /// `field` is the reading in body axes (x forward, y left, z up), uT, and `axes` is the tilt of
    /// the body. Worst error of the computation: 0.163 degree, from the arc tangent of `micromath`.
    /// `shared/tests/estimate/compass.rs` compares it with double precision over directions,
    /// tilts and strengths. An error of the tilt adds that error times the tangent of the field's
    /// inclination.
    ///
    /// # Errors
    /// [`CompassError`] for any reading that cannot be the earth's field.
    pub fn heading(&self, field: [f32; 3], axes: &LevelAxes) -> Result<Angle, CompassError> {
        if !field.iter().all(|component| component.is_finite()) {
            return Err(CompassError::NotFinite);
        }
        let [x, y, z] = core::array::from_fn(|axis| field[axis] - self.hard_iron[axis]);
        let [xx, yy, xy] = self.soft_iron;
        let [forward, left, up] = axes.of([xx * x + xy * y, xy * x + yy * y, z]);
        let horizontal = sqrt(forward * forward + left * left);
        let strength = sqrt(horizontal * horizontal + up * up);
        // An overflow gives infinity, which is out of range.
        if !(STRENGTH[0]..=STRENGTH[1]).contains(&strength) {
            return Err(CompassError::Strength(strength));
        }
        if !(horizontal >= HORIZONTAL_SHARE * strength) {
            return Err(CompassError::Steep(horizontal / strength));
        }
        Ok(direction(-left, forward) - self.declination)
    }
}

/// Returns the direction of the point (`x`, `y`). The point must be finite, and neither the origin
/// nor near an end of the number range, where `micromath` gives NaN or wrong values.
fn direction(y: f32, x: f32) -> Angle {
    Angle::from_radians(F32(y).atan2(F32(x)).0)
}
