//! One motor: from encoder counts to a velocity ([`observer`]), from set-points to a current ([`profile`], [`cascade`]),
//! from a current to a duty cycle ([`current`]). Positions are `i64` in 2^-32 turn of the output shaft, so that neither
//! precision nor range is lost with time; only differences become `f32`.

pub mod cascade;
pub mod current;
pub mod observer;
pub mod profile;

/// Radians in 2^-32 turn.
pub const RADIANS_PER_UNIT: f32 = core::f32::consts::TAU / 4_294_967_296.0;
/// 2^-32 turns in one radian.
pub const UNITS_PER_RADIAN: f32 = 4_294_967_296.0 / core::f32::consts::TAU;

/// `position` as radians; exact to 24 bits, so meant for differences.
pub fn to_radians(position: i64) -> f32 {
    position as f32 * RADIANS_PER_UNIT
}

/// `angle` in radians as 2^-32 turns; saturates, 0 for NaN.
pub fn from_radians(angle: f32) -> i64 {
    (angle * UNITS_PER_RADIAN) as i64
}
