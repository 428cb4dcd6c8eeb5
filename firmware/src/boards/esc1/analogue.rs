//! The analogue circuits of the board: zero, scale and thresholds, as they follow from its
//! resistors.
//!
//! | Part | Value | Source |
//! |---|---|---|
//! | shunt of a half bridge, to ground | 3 mOhm | `SimpleFOC`; FOC-Stim, `bsp_g431b_esc1.cpp` |
//! | from there to op-amp, comparator | 1.5 k | its forum, "B-G431B-ESC1 Current Control" |
//! | from these to ground, and to the reference | 2.2 k, 22 k | the same |
//! | gain of the op-amp in the chip | 16 | `sampling` sets it |
//! | divider of the supply voltage | 169 k, 18 k | `SimpleFOC`; FOC-Stim |
//!
//! The same thread says once that the op-amp's output without current is half the reference. So the
//! firmware works with any zero between 25 and 75 % of the range, and the thresholds follow from
//! the zero in the settings, which the calibration measures. Nothing here was measured on a board.

/// Reference of the converters, V.
const REFERENCE: f32 = 3.3;
/// Shunt, ohm.
const SHUNT: f32 = 0.003;
/// Resistors at the inputs of op-amp and comparator, ohm: from the shunt, to ground, to the
/// reference.
const FROM_SHUNT: f32 = 1_500.0;
const TO_GROUND: f32 = 2_200.0;
const TO_REFERENCE: f32 = 22_000.0;
/// Gain of the op-amp.
const GAIN: f32 = 16.0;
/// Resistors of the divider of the supply voltage, ohm.
const SUPPLY_RESISTORS: [f32; 2] = [169_000.0, 18_000.0];
/// Largest code of a converter with 12 bits.
const FULL_CODE: f32 = 4_095.0;

/// Conductance at the inputs, 1/ohm.
const CONDUCTANCE: f32 = 1.0 / FROM_SHUNT + 1.0 / TO_GROUND + 1.0 / TO_REFERENCE;
/// Voltage at the inputs per voltage of the shunt.
const PART: f32 = 1.0 / FROM_SHUNT / CONDUCTANCE;
/// Voltage at the inputs without current, V.
const BIAS: f32 = REFERENCE / TO_REFERENCE / CONDUCTANCE;

/// Current that moves the code by half of its range, A.
pub const FULL_SCALE_AMPERES: f32 = REFERENCE / 2.0 / (SHUNT * PART * GAIN);
/// Code of [`current`] without current.
pub const ZERO: i32 = 65_535 - (BIAS * GAIN / REFERENCE * 65_536.0) as i32;
/// Supply voltage per code, V.
pub const SUPPLY_PER_CODE: f32 =
    REFERENCE * (SUPPLY_RESISTORS[0] + SUPPLY_RESISTORS[1]) / SUPPLY_RESISTORS[1] / FULL_CODE;

/// Converts a right-aligned code of 12 bits to
/// [`Readings::currents`](tautrack::motor::bridge::Readings::currents). A current into the motor
/// flows up through the shunt, so it lowers the code.
#[inline]
pub fn current(code: u16) -> u16 {
    !(code << 4)
}

/// Current above the over-current of the current loop (150 % of the limit) at which the comparators
/// open the bridge, A: more than their offset of 9 mV (data sheet of the chip) means.
const ABOVE_OVER_CURRENT: f32 = 8.0;

/// Code of the converter that makes the threshold of the comparators, for a phase with this zero
/// ([`current`]) and current limit, A. The comparator notices currents from the motor into a low
/// side, and shorts between high and low side.
pub fn threshold(zero: i32, current_limit: f32) -> u16 {
    let bias = REFERENCE * (65_535 - zero) as f32 / 65_536.0 / GAIN;
    let amperes = 1.5 * current_limit + ABOVE_OVER_CURRENT;
    ((bias + SHUNT * PART * amperes) / REFERENCE * 4_096.0) as u16
}
