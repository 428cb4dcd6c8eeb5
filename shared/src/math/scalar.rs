//! The number type of the models: `f32` on the robot and `f64` on the host, with one source for
//! both.

use super::{float, radians, trig};
use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// A real number. Its functions are defined for every input and bit-identical on every target.
///
/// In a crate with `std`, the inherent methods of `f32` and `f64` hide those of this trait. Call
/// `Scalar::sqrt(x)` there.
pub trait Scalar:
    Copy
    + Debug
    + PartialOrd
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;

    /// Returns the number nearest to `value`. It costs nothing if `value` is a constant.
    fn from_f64(value: f64) -> Self;
    /// Returns the same number in double precision.
    fn to_f64(self) -> f64;
    /// Returns whether the number is neither NaN nor infinite.
    fn is_finite(self) -> bool;
    /// Returns the square root, correctly rounded. NaN below zero and for NaN.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Returns sine and cosine of an angle in radians.
    ///
    /// Worst error of `f32`: 9e-8 up to 8192 rad. Worst error of `f64`: 1.2e-16 and two units in
    /// the last place, up to 1e6 rad. Beyond these angles, and for NaN, both results are NaN
    /// (`shared/tests/math/scalar.rs`).
    fn sin_cos(self) -> (Self, Self);
    /// Returns the direction of the point (`x`, `self`) in radians, from -pi to pi; 0 at the
    /// origin.
    ///
    /// Worst error: 4e-7 rad for `f32` ([`trig::atan2`]), 9e-16 rad for `f64`. Special values are
    /// as in IEEE 754.
    #[must_use]
    fn atan2(self, x: Self) -> Self;
}

impl Scalar for f32 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;

    #[inline]
    fn from_f64(value: f64) -> Self {
        value as Self
    }
    #[inline]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    #[inline]
    fn sqrt(self) -> Self {
        float::sqrt(self)
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        radians::sin_cos_f32(self)
    }
    #[inline]
    fn is_finite(self) -> bool {
        f32::is_finite(self)
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        trig::atan2(self, x)
    }
}

impl Scalar for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;

    #[inline]
    fn from_f64(value: f64) -> Self {
        value
    }
    #[inline]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline]
    fn sqrt(self) -> Self {
        float::sqrt_f64(self)
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        radians::sin_cos_f64(self)
    }
    #[inline]
    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        trig::atan2_f64(self, x)
    }
}
