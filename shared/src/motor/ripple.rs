//! Finds a back-EMF that turns relative to the rotor's axes, or swings: the encoder stands still or
//! counts backwards, or two leads are swapped.
//!
//! A healthy rotor has no back-EMF in d. One that turns relative to its axes has it there as an
//! alternating voltage. Errors of the resistance and of the dead time are nearly constant, so the
//! bound of an alternating voltage is much lower than that of a constant one.

use super::current::VOLTAGE_FULL_SCALE;
use crate::constants::CONTROL_PERIOD;
use crate::math::limit;

/// Part of the difference to a new value that the filters cover in a control period: 10 ms.
const FILTER: f32 = 0.1;
/// Part of a change of the back-EMF that an angle leaves in d which still counts as right: the sine
/// of 20 degrees.
const RIGHT: f32 = 0.35;

/// Alternating voltage in d that nothing explains.
#[derive(Clone, Debug)]
pub struct Ripple {
    /// Inductance in d divided by the control period, V/A.
    inductance: f32,
    /// Current in d of the previous period, A.
    direct: f32,
    /// Filtered voltage and filtered back-EMF by the encoder, V.
    mean: f32,
    mean_emf: f32,
    /// Square of the distance to the filtered voltage, minus that of its bound, filtered, V^2.
    excess: f32,
}

impl Ripple {
    /// Creates a filter at rest, for a motor with this inductance in d, henry.
    pub fn new(inductance: f32) -> Self {
        Self {
            inductance: inductance * (1.0 / CONTROL_PERIOD),
            direct: 0.0,
            mean: 0.0,
            mean_emf: 0.0,
            excess: 0.0,
        }
    }

    /// Forgets everything: the voltage is not known.
    pub fn reset(&mut self) {
        (self.mean, self.mean_emf, self.excess) = (0.0, 0.0, 0.0);
    }

    /// Returns whether the voltage does not alternate.
    pub fn is_calm(&self) -> bool {
        self.excess <= 0.0
    }

    /// Evaluates one control period: the voltage in d, V, without that of resistance and coupling,
    /// the current in d, A, the back-EMF by the encoder, V, and the voltage by which the first one
    /// may alternate, V. NaN counts as 0.
    #[inline]
    pub fn update(&mut self, voltage: f32, direct: f32, emf: f32, bound: f32) {
        let rising = (direct - self.direct) * self.inductance;
        self.direct = direct;
        let voltage = limit(voltage - rising, VOLTAGE_FULL_SCALE);
        self.mean += (voltage - self.mean) * FILTER;
        let emf = limit(emf, VOLTAGE_FULL_SCALE);
        self.mean_emf += (emf - self.mean_emf) * FILTER;
        let away = voltage - self.mean;
        let bound = limit(bound, VOLTAGE_FULL_SCALE) + RIGHT * (emf - self.mean_emf).abs();
        self.excess += (away * away - bound * bound - self.excess) * FILTER;
    }
}
