//! Heading from a three-axis magnetometer on a body that is tilted.

use crate::math::sqrt;
use crate::settings::{Setting, Settings};
use crate::stability::attitude::LevelAxes;
use crate::units::Angle;
use micromath::F32;

/// Field strengths that the earth has near its surface, with room for a poor calibration, uT.
pub const STRENGTH: [f32; 2] = [15.0, 90.0];
/// Least horizontal share of the field: an inclination of 80 degrees. Beyond it a degree of tilt turns the heading by six.
pub const HORIZONTAL_SHARE: f32 = 0.174;

/// Why a reading gives no heading.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum CompassError {
    /// A component is NaN or infinite.
    NotFinite,
    /// The field, without the hard iron, is weaker or stronger than the earth's, uT.
    Strength(f32),
    /// The horizontal share of the field is below [`HORIZONTAL_SHARE`].
    Steep(f32),
}

/// Compass with its calibration.
#[derive(Clone, Copy, Debug, Default)]
pub struct Compass {
    hard_iron: [f32; 3],
    declination: Angle,
}

impl Compass {
    /// Compass that takes off `hard_iron`, the field of the robot's own magnets in body axes, uT, where the magnetic north
    /// lies east of the true one by `declination`.
    pub fn new(hard_iron: [f32; 3], declination: Angle) -> Self {
        Self {
            hard_iron,
            declination,
        }
    }

    /// As the settings say.
    pub fn with_settings(settings: &Settings) -> Self {
        let microtesla = |setting| settings.scaled(setting, 1e-3);
        Self::new(
            [
                microtesla(Setting::HardIronForward),
                microtesla(Setting::HardIronLeft),
                microtesla(Setting::HardIronUp),
            ],
            Angle::from_degrees(settings.scaled(Setting::Declination, 1e-3)),
        )
    }

    /// The paper's q4: heading from true north, counter-clockwise seen from above.
    ///
    /// `field` is the reading in body axes (x forward, y left, z up), uT, `axes` the body's tilt. Worst error of the
    /// computation 0.163 degree, from the arc tangent of `micromath` (`host-tests/tests/simulator/estimate.rs` sweeps directions, tilts and
    /// strengths against double precision); an error of the tilt adds itself times the tangent of the field's inclination.
    ///
    /// # Errors
    /// [`CompassError`], for any reading that is no earth's field.
    pub fn heading(&self, field: [f32; 3], axes: &LevelAxes) -> Result<Angle, CompassError> {
        if !field.iter().all(|component| component.is_finite()) {
            return Err(CompassError::NotFinite);
        }
        let [forward, left, up] = axes.of(core::array::from_fn(|axis| {
            field[axis] - self.hard_iron[axis]
        }));
        let horizontal = sqrt(forward * forward + left * left);
        let strength = sqrt(horizontal * horizontal + up * up);
        // An overflow is infinite, and so out of range.
        if !(STRENGTH[0]..=STRENGTH[1]).contains(&strength) {
            return Err(CompassError::Strength(strength));
        }
        if !(horizontal >= HORIZONTAL_SHARE * strength) {
            return Err(CompassError::Steep(horizontal / strength));
        }
        Ok(direction(-left, forward) - self.declination)
    }
}

/// Direction of the point (`x`, `y`), which is finite, and neither the origin nor near an end of the number range: there
/// `micromath` gives NaN or nonsense.
fn direction(y: f32, x: f32) -> Angle {
    Angle::from_radians(F32(y).atan2(F32(x)).0)
}
