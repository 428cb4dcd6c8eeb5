//! Sine and cosine of an angle in radians, in single and double precision. Whole quarter turns are
//! subtracted (method of Cody and Waite). The rest, at most an eighth of a turn, goes into a Taylor
//! series.

use super::scalar::Scalar;
use core::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// Difference between a quarter turn and `FRAC_PI_2`.
const QUARTER_REST: f64 = 6.123_233_995_736_766e-17;
/// Largest argument, rad. Up to it, the number of quarter turns times each of the first two parts
/// below is exact.
const LARGEST_F32: f32 = 8192.0;
const LARGEST_F64: f64 = 1e6;

/// A quarter turn in three parts. The first two have few bits, so that their products with the
/// number of quarter turns are exact.
const PARTS_F64: [f64; 3] = {
    let high = leading_bits(FRAC_PI_2, 33);
    [high, FRAC_PI_2 - high, QUARTER_REST]
};
const PARTS_F32: [f32; 3] = {
    let high = leading_bits(FRAC_PI_2, 11);
    let middle = leading_bits(FRAC_PI_2 - high, 11);
    [
        high as f32,
        middle as f32,
        (FRAC_PI_2 - high - middle) as f32,
    ]
};

/// Coefficients of `sin(x) / x` and `cos(x)` in powers of `x^2`.
const SINE_F64: [f64; 9] = taylor(1);
const COSINE_F64: [f64; 9] = taylor(0);
const SINE_F32: [f32; 5] = narrow(taylor(1));
const COSINE_F32: [f32; 6] = narrow(taylor(0));

const fn leading_bits(value: f64, bits: u32) -> f64 {
    f64::from_bits(value.to_bits() & (u64::MAX << (53 - bits)))
}

/// Computes the coefficients of `x^(2 k)`: `(-1)^k / (2 k + first)!`.
const fn taylor<const N: usize>(first: u32) -> [f64; N] {
    let mut coefficients = [1.0; N];
    let mut k = 1;
    while k < N {
        let top = (2 * k) as f64 + first as f64;
        coefficients[k] = -coefficients[k - 1] / (top * (top - 1.0));
        k += 1;
    }
    coefficients
}

const fn narrow<const N: usize>(wide: [f64; N]) -> [f32; N] {
    let mut all = [0.0; N];
    let mut k = 0;
    while k < N {
        all[k] = wide[k] as f32;
        k += 1;
    }
    all
}

#[inline]
fn evaluate<S: Scalar, const N: usize>(coefficients: &[S; N], square: S) -> S {
    coefficients
        .iter()
        .rev()
        .fold(S::ZERO, |sum, coefficient| sum * square + *coefficient)
}

/// Returns sine and cosine of the sum of `quarters` quarter turns and the angle that has this
/// `sine` and `cosine`.
#[inline]
fn turned<S: Scalar>(quarters: i32, sine: S, cosine: S) -> (S, S) {
    match quarters & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

#[inline]
pub(super) fn sin_cos_f32(angle: f32) -> (f32, f32) {
    // The comparison is false for NaN.
    if !(angle.abs() <= LARGEST_F32) {
        return (f32::NAN, f32::NAN);
    }
    let count = angle * (FRAC_2_PI as f32);
    let quarters = (count + if count < 0.0 { -0.5 } else { 0.5 }) as i32;
    let count = quarters as f32;
    let rest = angle - count * PARTS_F32[0] - count * PARTS_F32[1] - count * PARTS_F32[2];
    let square = rest * rest;
    let sine = rest * evaluate(&SINE_F32, square);
    turned(quarters, sine, evaluate(&COSINE_F32, square))
}

#[inline]
pub(super) fn sin_cos_f64(angle: f64) -> (f64, f64) {
    if !(angle.abs() <= LARGEST_F64) {
        return (f64::NAN, f64::NAN);
    }
    let count = angle * FRAC_2_PI;
    let quarters = (count + if count < 0.0 { -0.5 } else { 0.5 }) as i32;
    let count = f64::from(quarters);
    let rest = angle - count * PARTS_F64[0] - count * PARTS_F64[1] - count * PARTS_F64[2];
    let square = rest * rest;
    let sine = rest * evaluate(&SINE_F64, square);
    turned(quarters, sine, evaluate(&COSINE_F64, square))
}
