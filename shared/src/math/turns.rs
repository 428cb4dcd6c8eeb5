//! Positions of shafts that make many turns.

use super::to_i32;
use crate::units::Angle;
use core::ops::{Add, AddAssign, Neg, Sub};

/// Position of a shaft, or the distance between two, in 2^-32 turn. It wraps after 2^31 turns, and
/// so do sums and differences.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
pub struct Turns(i64);

impl Turns {
    /// The position 0.
    pub const ZERO: Self = Self(0);
    /// The lowest position.
    pub const MIN: Self = Self(i64::MIN);
    /// The highest position.
    pub const MAX: Self = Self(i64::MAX);
    /// Units of 2^-32 turn per radian.
    pub const PER_RADIAN: f32 = 4_294_967_296.0 / core::f32::consts::TAU;

    /// Creates a position from its binary form, 2^-32 turn.
    #[inline]
    pub const fn from_bits(bits: i64) -> Self {
        Self(bits)
    }

    /// Returns the binary form, 2^-32 turn.
    #[inline]
    pub const fn to_bits(self) -> i64 {
        self.0
    }

    /// Converts `angle`, rad. Saturates at 2^31 turns; 0 for NaN.
    #[inline]
    pub fn from_radians(angle: f32) -> Self {
        const TURN: f32 = 4_294_967_296.0;
        let turns = angle * (1.0 / core::f32::consts::TAU);
        let whole = to_i32(turns + f32::copysign(0.5, turns));
        // At most half a turn and exact, so that scaling it by a power of two loses nothing.
        let rest = to_i32((turns - whole as f32) * TURN);
        Self(i64::from(whole.saturating_add(rest >> 31)) << 32 | i64::from(rest as u32))
    }

    /// Converts to radians. The result is exact to 24 bits, so it is meant for differences.
    #[inline]
    pub fn radians(self) -> f32 {
        // The position is split into the nearest number of whole turns and the rest, each of 32
        // bits, because the core converts 32 bits in one instruction. A small difference of either
        // sign has no whole turn, in which its digits could be lost.
        let rest = self.0 as i32;
        let turns = (self.0.wrapping_sub(i64::from(rest)) >> 32) as i32;
        turns as f32 * core::f32::consts::TAU
            + rest as f32 * (core::f32::consts::TAU / 4_294_967_296.0)
    }

    /// Returns the direction of the shaft, without its whole turns.
    #[inline]
    pub const fn angle(self) -> Angle {
        Angle::from_bits(self.0 as i32)
    }

    /// Returns the distance from 0, 2^-32 turn.
    #[inline]
    pub const fn distance(self) -> u64 {
        self.0.unsigned_abs()
    }
}

impl From<Angle> for Turns {
    fn from(angle: Angle) -> Self {
        Self(i64::from(angle.to_bits()))
    }
}

impl Add for Turns {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self(self.0.wrapping_add(other.0))
    }
}

impl AddAssign for Turns {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Turns {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self(self.0.wrapping_sub(other.0))
    }
}

impl Neg for Turns {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self(self.0.wrapping_neg())
    }
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
            let radians = Turns::from_bits(position).radians();
            assert!(
                (f64::from(radians) - expected).abs() <= 2.5e-7 * expected.abs(),
                "{position}"
            );
            let back = Turns::from_radians(radians).to_bits() as f64 * unit;
            assert!(
                (back - expected).abs() <= 4e-7 * expected.abs() + unit,
                "{position} {radians}"
            );
        }
    }

    #[test]
    fn what_is_too_large_saturates_and_what_is_no_number_is_zero() {
        assert_eq!(Turns::from_radians(f32::NAN), Turns::ZERO);
        assert!(Turns::from_radians(f32::INFINITY).to_bits() > i64::MAX - (1 << 32));
        assert!(Turns::from_radians(f32::MIN).to_bits() < i64::MIN + (1 << 32));
        assert_eq!(Turns::from_radians(-0.0), Turns::ZERO);
        assert_eq!(
            Turns::from_bits(i64::MIN).radians(),
            -2_147_483_648.0 * core::f32::consts::TAU
        );
    }
}
