//! Adds the current that cancels the cogging torque, in the PWM interrupt: a wave of the electrical
//! angle, from a table of one period.

use crate::math::{sin_cos_q30, to_i32};
use crate::motor::cogging::Wave;
use crate::motor::rotor::ElectricalAngle;
use crate::units::Angle;

/// Steps of the table, as a power of two. Between two of them it interpolates, so the current is at
/// most 0.5 % of its amplitude wrong.
const STEP_BITS: u32 = 5;

/// Current over one period of the cogging.
#[derive(Clone, Debug)]
pub(super) struct Cogging {
    /// Periods in an electrical turn.
    periods: i32,
    /// 2^15 is full scale.
    table: [i16; (1 << STEP_BITS) + 1],
}

impl Cogging {
    /// Computes the table of this current, A.
    pub fn new(periods: i32, wave: Wave, full_scale: f32) -> Self {
        let per_ampere = (1 << 15) as f32 / full_scale / (1 << 30) as f32;
        let mut table = [0; (1 << STEP_BITS) + 1];
        for (step, value) in table.iter_mut().enumerate() {
            let angle = Angle::from_bits((step as i32) << (32 - STEP_BITS));
            let (sin, cos) = sin_cos_q30(angle);
            let current = wave.cosine * cos as f32 + wave.sine * sin as f32;
            *value = crate::math::to_i16(current * per_ampere);
        }
        Self { periods, table }
    }

    /// Returns the current at this angle; 2^30 is full scale.
    #[inline]
    pub fn current(&self, angle: ElectricalAngle) -> i32 {
        let phase = angle.0.to_bits().wrapping_mul(self.periods) as u32;
        let step = (phase >> (32 - STEP_BITS)) as usize;
        let (Some(near), Some(far)) = (self.table.get(step), self.table.get(step + 1)) else {
            return 0; // does not happen: a step is below 2^STEP_BITS
        };
        let part = (phase >> (32 - STEP_BITS - 15) & 0x7fff) as i32;
        let (near, far) = (i32::from(*near), i32::from(*far));
        (near << 15) + (far - near) * part
    }
}

/// Largest current of a wave, 2^30 is full scale; rounded up.
pub(super) fn amplitude(wave: Wave, full_scale: f32) -> i32 {
    let amperes = crate::math::sqrt(wave.square());
    to_i32(amperes * ((1 << 30) as f32 / full_scale)).saturating_add(1 << 16)
}
