//! Quantities whose unit is in the type, where a mix-up would be expensive.

use core::f64::consts::PI;
use core::ops::{Add, AddAssign, Neg, Sub, SubAssign};

/// A direction: a binary angle, the full circle being 2^32.
///
/// Bits 0 are 0, `0x4000_0000` is a quarter turn, `i32::MIN` is half a turn. Going round is the wrap of the integer, so
/// addition, subtraction and negation can neither overflow nor lose precision; the negative of half a turn is half a turn.
/// One bit is 1.46e-9 rad.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Angle(i32);

/// Bits of one radian.
const BITS_PER_RADIAN: f64 = 2_147_483_648.0 / PI;
/// Bits of one degree.
const BITS_PER_DEGREE: f64 = 2_147_483_648.0 / 180.0;

impl Angle {
    /// Straight ahead.
    pub const ZERO: Self = Self(0);
    /// 90 degrees, counter-clockwise.
    pub const QUARTER_TURN: Self = Self(1 << 30);
    /// 180 degrees.
    pub const HALF_TURN: Self = Self(i32::MIN);

    /// Angle from its binary form, in 2^-32 of a turn.
    pub const fn from_bits(bits: i32) -> Self {
        Self(bits)
    }

    /// The binary form, in 2^-32 of a turn, from -2^31 (minus half a turn) to 2^31 - 1.
    pub const fn to_bits(self) -> i32 {
        self.0
    }

    /// Angle from radians, any number of turns: the nearest binary angle, wrapped, one bit off at most up to 1e6 rad.
    ///
    /// Total: NaN and infinities give [`Self::ZERO`], and so does what exceeds 1e9 rad, where an `f32` no longer tells
    /// directions apart. Cost: one double-precision product, in software on a Cortex-M4F; not for interrupts.
    pub const fn from_radians(radians: f32) -> Self {
        Self::from_scaled(radians as f64 * BITS_PER_RADIAN)
    }

    /// Angle from degrees; otherwise as [`Self::from_radians`].
    pub const fn from_degrees(degrees: f32) -> Self {
        Self::from_scaled(degrees as f64 * BITS_PER_DEGREE)
    }

    const fn from_scaled(bits: f64) -> Self {
        // Above this the cast to i64 would saturate soon; false for NaN.
        if bits.abs() < 1e18 {
            let half = if bits < 0.0 { -0.5 } else { 0.5 };
            Self((bits + half) as i64 as i32)
        } else {
            Self::ZERO
        }
    }

    /// The angle in radians, from -pi to pi; worst error 3e-7 rad, near half a turn, less in proportion to the angle.
    pub const fn radians(self) -> f32 {
        self.0 as f32 * ((1.0 / BITS_PER_RADIAN) as f32)
    }

    /// The angle in degrees, from -180 to 180; worst error 2e-5.
    pub const fn degrees(self) -> f32 {
        self.0 as f32 * ((1.0 / BITS_PER_DEGREE) as f32)
    }
}

impl Add for Angle {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0.wrapping_add(other.0))
    }
}

impl Sub for Angle {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(self.0.wrapping_sub(other.0))
    }
}

impl Neg for Angle {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.wrapping_neg())
    }
}

impl AddAssign for Angle {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Angle {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
