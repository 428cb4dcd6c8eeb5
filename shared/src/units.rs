//! Quantities whose unit is in the type, where a mix-up would be expensive.

use core::f64::consts::PI;
use core::ops::{Add, AddAssign, Neg, Sub, SubAssign};
use fixed::types::I4F28;

/// A length in metres, or a derivative in metres per radian: resolution 2^-28 (3.7 nm), range -8 to 8.
pub type Length = I4F28;

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
/// 32 more bits of the same: whole bits in the high word.
const fn with_fraction(bits: f64) -> u64 {
    (bits * 4_294_967_296.0) as u64
}

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
    /// Total: NaN and infinities give [`Self::ZERO`], and so does what reaches 2^30 rad, where an `f32` no longer tells
    /// directions apart. Integer arithmetic alone; cost on Cortex-M4: see docs/cost.md.
    #[inline]
    pub const fn from_radians(radians: f32) -> Self {
        const PER_RADIAN: u64 = with_fraction(BITS_PER_RADIAN);
        Self::from_scaled(radians, PER_RADIAN)
    }

    /// Angle from degrees; otherwise as [`Self::from_radians`].
    #[inline]
    pub const fn from_degrees(degrees: f32) -> Self {
        const PER_DEGREE: u64 = with_fraction(BITS_PER_DEGREE);
        Self::from_scaled(degrees, PER_DEGREE)
    }

    /// `value` times `per_unit` bits, the latter with 32 fractional bits.
    #[inline]
    const fn from_scaled(value: f32, per_unit: u64) -> Self {
        let bits = value.to_bits();
        // value = mantissa * 2^-down, the mantissa of a normal number having 24 bits; smaller numbers are less than a bit anyway.
        let mantissa = (bits & 0x007f_ffff | 0x0080_0000) as u64;
        let down = 150 - (bits >> 23 & 0xff) as i32;
        // Below 2^24 times 2^30, so the sum has room, and whatever of it exceeds 32 bits is whole turns.
        let product = mantissa * (per_unit >> 32) + ((mantissa * (per_unit & 0xffff_ffff)) >> 32);
        let magnitude = if down > 55 || down < -6 {
            0
        } else if down > 0 {
            (product + (1 << (down - 1))) >> down
        } else {
            product << -down
        } as i32;
        Self(if value < 0.0 {
            magnitude.wrapping_neg()
        } else {
            magnitude
        })
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
