//! Digits in the output registers of a chip.

use crate::link::ChipFault;
use crate::motor::model::noise::Noise;

/// Writes the digits for `values` to `registers`, two bytes each: rounded and limited to the range
/// of the registers, 0 for NaN. With the fault, each is off by another number of `noise`.
pub(super) fn write(
    registers: &mut [u8],
    values: &[f32],
    digits_per_unit: f32,
    fault: Option<ChipFault>,
    noise: &mut Noise,
) {
    for (register, value) in registers.chunks_exact_mut(2).zip(values) {
        let scaled = value * digits_per_unit;
        let half = if scaled < 0.0 { -0.5 } else { 0.5 };
        // The conversion saturates.
        let mut digits = (scaled + half) as i16;
        if fault == Some(ChipFault::Noise) {
            digits = digits.saturating_add(noise.bits() as i16 / 4);
        }
        register.copy_from_slice(&digits.to_le_bytes());
    }
}
