//! Thermal model of first order: the heat that a current leaves in a winding or in a bridge (I2t).

use crate::constants::CONTROL_PERIOD;
use crate::math::min;

/// Part of the heat at which the current begins to be reduced: the last tenth.
const STEEPNESS: f32 = 10.0;

/// Heat of one part, as a fraction of the heat that the continuous current leaves in it.
///
/// The heat follows the square of the current with one time constant. Near 1 the allowed current
/// falls from the peak to the continuous current, so the heat does not exceed 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Heat {
    continuous: f32,
    /// Heat per A^2 of a current that lasts for ever.
    per_square: f32,
    /// Largest heat that a current can leave. A larger one is an error of the measurement.
    largest: f32,
    /// Part of the difference that one control period covers.
    rate: f32,
    level: f32,
}

impl Heat {
    /// Creates the model of a part that carries `continuous` A for ever, with this time constant,
    /// s. No current is larger than twice `peak`, A.
    ///
    /// It starts with the full heat, because nothing is known of the time before the power-up. A
    /// tenth of the time constant later, the peak current is allowed.
    pub fn new(continuous: f32, peak: f32, time_constant: f32) -> Self {
        let largest = 2.0 * peak / continuous;
        Self {
            continuous,
            per_square: 1.0 / (continuous * continuous),
            largest: largest * largest,
            rate: CONTROL_PERIOD / time_constant,
            level: 1.0,
        }
    }

    /// Begins with the heat of `before`, the same part with another continuous or peak current.
    pub fn take_over(&mut self, before: &Self) {
        self.level = before.level * (self.per_square / before.per_square);
    }

    /// Advances by one control period with the square of the current, A^2. NaN counts as the
    /// largest current.
    ///
    /// Worst error: 0.6 % of the heat for the longest time constant, 100 s.
    #[inline]
    pub fn update(&mut self, square: f32) {
        let heat = square * self.per_square;
        let heat = if heat < self.largest {
            heat
        } else {
            self.largest
        };
        self.level += (heat - self.level) * self.rate;
    }

    /// Returns the current that is allowed now, A, for a part whose peak current is `peak`.
    #[inline]
    pub fn allowed(&self, peak: f32) -> f32 {
        let left = (1.0 - self.level) * STEEPNESS;
        self.continuous + (peak - self.continuous) * fraction(left)
    }

    /// Returns the heat in thousandths of the heat that the continuous current leaves.
    pub fn thousandths(&self) -> u16 {
        (min(self.level, 65.0) * 1e3) as u16
    }
}

/// Limits `value` to 0..=1; 0 for NaN.
#[inline]
pub(super) fn fraction(value: f32) -> f32 {
    if value >= 1.0 {
        1.0
    } else if value > 0.0 {
        value
    } else {
        0.0
    }
}
