//! Types that carry their unit, for quantities whose confusion would be expensive.

use core::f64::consts::PI;
use core::ops::{Add, AddAssign, Neg, Sub, SubAssign};
use fixed::types::I4F28;

/// A length in metres, or a derivative in metres per radian: resolution 2^-28 (3.7 nm), range -8 to
/// 8.
pub type Length = I4F28;

/// A direction as a binary angle: the full circle is 2^32.
///
/// The bits 0 are the angle 0, `0x4000_0000` is a quarter turn, `i32::MIN` is half a turn. The
/// integer wraps where the angle wraps. So addition, subtraction and negation can neither overflow
/// nor lose precision. The negative of half a turn is half a turn. One bit is 1.46e-9 rad.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Angle(i32);

/// Bits per radian.
const BITS_PER_RADIAN: f64 = 2_147_483_648.0 / PI;
/// Bits per degree.
const BITS_PER_DEGREE: f64 = 2_147_483_648.0 / 180.0;
/// Adds 32 fraction bits: the high word holds the whole bits.
const fn with_fraction(bits: f64) -> u64 {
    (bits * 4_294_967_296.0) as u64
}

impl Angle {
    /// Zero: straight ahead.
    pub const ZERO: Self = Self(0);
    /// 90 degrees, counter-clockwise.
    pub const QUARTER_TURN: Self = Self(1 << 30);
    /// 180 degrees.
    pub const HALF_TURN: Self = Self(i32::MIN);

    /// Creates an angle from its binary form, 2^-32 turn.
    #[inline]
    pub const fn from_bits(bits: i32) -> Self {
        Self(bits)
    }

    /// Returns the binary form, 2^-32 turn, from -2^31 (minus half a turn) to 2^31 - 1.
    pub const fn to_bits(self) -> i32 {
        self.0
    }

    /// Converts radians of any number of turns to the nearest binary angle, wrapped. The result is
    /// at most one bit off up to 1e6 rad.
    ///
    /// It is defined for every input: NaN and infinities give [`Self::ZERO`]. So do values from
    /// 2^30 rad on, where an `f32` cannot tell directions apart. It uses integer arithmetic only.
    #[inline]
    pub const fn from_radians(radians: f32) -> Self {
        const PER_RADIAN: u64 = with_fraction(BITS_PER_RADIAN);
        Self::from_scaled(radians, PER_RADIAN)
    }

    /// Converts degrees to a binary angle; otherwise as [`Self::from_radians`].
    #[inline]
    pub const fn from_degrees(degrees: f32) -> Self {
        const PER_DEGREE: u64 = with_fraction(BITS_PER_DEGREE);
        Self::from_scaled(degrees, PER_DEGREE)
    }

    /// Multiplies `value` by `per_unit` bits, which have 32 fraction bits.
    #[inline]
    const fn from_scaled(value: f32, per_unit: u64) -> Self {
        let bits = value.to_bits();
        // value = mantissa * 2^-down. The mantissa of a normal number has 24 bits. Smaller numbers
        // are less than one bit in any case.
        let mantissa = (bits & 0x007f_ffff | 0x0080_0000) as u64;
        let down = 150 - (bits >> 23 & 0xff) as i32;
        // The products are below 2^24 times 2^30, so the sum does not overflow. Its bits beyond the
        // lowest 32 are whole turns.
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

    /// Returns the angle in radians, from -pi to pi. Worst error: 3e-7 rad near half a turn,
    /// smaller in proportion to the angle.
    pub const fn radians(self) -> f32 {
        self.0 as f32 * ((1.0 / BITS_PER_RADIAN) as f32)
    }

    /// Returns the angle in degrees, from -180 to 180. Worst error: 2e-5 degree.
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
