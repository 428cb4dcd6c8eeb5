//! Estimation and control of one motor.
//!
//! * [`observer`]: position and velocity from encoder counts
//! * [`profile`]: motion of a set-point within its limits
//! * [`cascade`]: current from a set-point
//! * [`cogging`]: finds the current that cancels the cogging torque
//! * [`current`]: compare values of the half bridges from a current, in the PWM interrupt
//! * [`calibration`]: measures the motor and its sensors on request
//! * [`alignment`]: finds the angle of a rotor whose sensor only counts
//! * [`limits`]: what a motor, a bridge and a supply can carry; the last limiter of the current
//! * [`back_emf`]: compares the voltage of the bridge with the speed of the encoder
//! * [`angle_watch`]: watches the rotor's angle at low speed
//! * [`angle_probe`]: finds a wrong rotor angle with a current that makes no torque
//! * [`ripple`]: finds a back-EMF that turns relative to the rotor's axes
//! * [`encoder_steps`]: finds a noisy encoder
//! * [`halls`]: counts the rotor from Hall sensors
//! * [`index`]: finds lost counts, and corrects the rotor's angle
//! * [`bridge`]: readings and commands of the power stage
//! * [`capture`]: records signals of the PWM interrupt
//! * `model`: simulated motors, for boards without hardware (feature `lockstep`)
//! * [`rotor`]: electrical angle of a three-phase motor
//!
//! Positions are `i64` in 2^-32 turn of the output shaft, so that they lose neither precision nor
//! range over time. Only differences of positions become `f32`.

pub mod alignment;
pub mod angle_probe;
pub mod angle_watch;
pub mod back_emf;
pub mod bridge;
pub mod calibration;
pub mod capture;
pub mod cascade;
pub mod cogging;
pub mod current;
pub mod encoder_steps;
pub mod halls;
pub mod index;
pub mod limits;
#[cfg(feature = "lockstep")]
pub mod model;
pub mod observer;
pub mod profile;
pub mod ripple;
pub mod rotor;

use crate::math::to_i32;

/// Radians per position unit of 2^-32 turn.
pub const RADIANS_PER_UNIT: f32 = core::f32::consts::TAU / 4_294_967_296.0;
/// Position units of 2^-32 turn per radian.
pub const UNITS_PER_RADIAN: f32 = 4_294_967_296.0 / core::f32::consts::TAU;

/// Converts `position`, 2^-32 turn, to radians. The result is exact to 24 bits, so it is meant for
/// differences.
#[inline]
pub fn to_radians(position: i64) -> f32 {
    // The position is split into the nearest number of whole turns and the rest, each of 32 bits,
    // because the core converts 32 bits in one instruction. A small difference of either sign has
    // no whole turn, in which its digits could be lost.
    let rest = position as i32;
    let turns = (position.wrapping_sub(i64::from(rest)) >> 32) as i32;
    turns as f32 * core::f32::consts::TAU + rest as f32 * RADIANS_PER_UNIT
}

/// Converts `angle`, rad, to 2^-32 turn. Saturates at 2^31 turns; 0 for NaN.
#[inline]
pub fn from_radians(angle: f32) -> i64 {
    const TURN: f32 = 4_294_967_296.0;
    let turns = angle * (1.0 / core::f32::consts::TAU);
    let whole = to_i32(turns + f32::copysign(0.5, turns));
    // At most half a turn and exact, so that scaling it by a power of two loses nothing.
    let rest = to_i32((turns - whole as f32) * TURN);
    i64::from(whole.saturating_add(rest >> 31)) << 32 | i64::from(rest as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radians_and_units_agree_with_double_precision_at_every_size() {
        let unit = core::f64::consts::TAU / 4_294_967_296.0;
        let mut bits = 1_u64;
        for step in 0..200_000 {
            bits = bits
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let position = bits as i64 >> (step % 62);
            let expected = position as f64 * unit;
            let radians = to_radians(position);
            assert!(
                (f64::from(radians) - expected).abs() <= 2.5e-7 * expected.abs(),
                "{position}"
            );
            let back = from_radians(radians) as f64 * unit;
            assert!(
                (back - expected).abs() <= 4e-7 * expected.abs() + unit,
                "{position} {radians}"
            );
        }
    }

    #[test]
    fn what_is_too_large_saturates_and_what_is_no_number_is_zero() {
        assert_eq!(from_radians(f32::NAN), 0);
        assert!(from_radians(f32::INFINITY) > i64::MAX - (1 << 32));
        assert!(from_radians(f32::MIN) < i64::MIN + (1 << 32));
        assert_eq!(from_radians(-0.0), 0);
        assert_eq!(
            to_radians(i64::MIN),
            -2_147_483_648.0 * core::f32::consts::TAU
        );
    }
}
