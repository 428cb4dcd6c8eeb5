//! Sine and cosine of an angle in radians, in single and double precision. Whole quarter turns are
//! subtracted (method of Cody and Waite). The rest, at most an eighth of a turn, goes into a
//! polynomial: a Taylor series in single precision, a minimax polynomial in double precision.

use core::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// Difference between a quarter turn and `FRAC_PI_2`.
const QUARTER_REST: f64 = 6.123_233_995_736_766e-17;
/// Difference between `QUARTER_REST` and the exact difference.
const QUARTER_LAST: f64 = 1.497_384_904_859_169_8e-33;
/// Largest argument, rad. Up to it, the number of quarter turns times each part below but the last
/// is exact.
const LARGEST_F32: f32 = 8192.0;
const LARGEST_F64: f64 = 1e6;

/// A quarter turn in parts. All but the last have few bits, so that their products with the number
/// of quarter turns are exact.
const PARTS_F64: [f64; 4] = {
    let high = leading_bits(FRAC_PI_2, 33);
    let rest = leading_bits(QUARTER_REST, 33);
    [
        high,
        FRAC_PI_2 - high,
        rest,
        (QUARTER_REST - rest) - QUARTER_LAST,
    ]
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
const SINE_F32: [f32; 5] = narrow(taylor(1));
const COSINE_F32: [f32; 6] = narrow(taylor(0));

/// Coefficients of `(sin(x) - x) / x^3` and `(cos(x) - 1 + x^2 / 2) / x^4` in powers of `x^2`.
///
/// They are minimax polynomials for an eighth of a turn, found with Remez' exchange algorithm in 40
/// digits. Their relative errors, of the whole sine and of the whole cosine, are below 4e-18.
const SINE_F64: [f64; 6] = [
    -0.166_666_666_666_666_3,
    0.008_333_333_333_322_108,
    -0.000_198_412_698_295_801_66,
    2.755_731_361_801_741_5e-6,
    -2.505_074_721_820_063_3e-8,
    1.589_619_763_574_779_6e-10,
];
const COSINE_F64: [f64; 6] = [
    0.041_666_666_666_666_6,
    -0.001_388_888_888_887_412_5,
    2.480_158_728_948_218_4e-5,
    -2.755_731_435_233_285e-7,
    2.087_572_327_325_901_6e-9,
    -1.135_964_780_578_847_5e-11,
];

/// Added to a number below 2^51, it leaves the nearest integer in the low bits of the sum.
const ROUNDING: f64 = 1.5 * (1_u64 << 52) as f64;

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
fn evaluate<const N: usize>(coefficients: &[f32; N], square: f32) -> f32 {
    coefficients
        .iter()
        .rev()
        .fold(0.0, |sum, coefficient| sum * square + *coefficient)
}

/// Returns sine and cosine of the sum of `quarters` quarter turns and the angle that has this
/// `sine` and `cosine`.
#[inline]
fn turned(quarters: i32, sine: f32, cosine: f32) -> (f32, f32) {
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
    let rounded = angle * FRAC_2_PI + ROUNDING;
    let count = rounded - ROUNDING;
    let rest = PARTS_F64
        .iter()
        .fold(angle, |rest, part| rest - count * part);
    let square = rest * rest;
    let sine = rest + rest * square * evaluate_f64(&SINE_F64, square);
    // The rounding error of `1 - half` goes back into the sum.
    let half = 0.5 * square;
    let most = 1.0 - half;
    let lost = (1.0 - most) - half;
    let cosine = most + (lost + square * square * evaluate_f64(&COSINE_F64, square));
    turned_f64(rounded.to_bits(), sine, cosine)
}

/// Evaluates a polynomial in pairs of terms, because a processor computes independent products at
/// the same time.
#[inline]
fn evaluate_f64(c: &[f64; 6], x: f64) -> f64 {
    let square = x * x;
    (c[0] + c[1] * x) + square * ((c[2] + c[3] * x) + square * (c[4] + c[5] * x))
}

/// Same as [`turned`], without branches, because a processor cannot predict the quarter turn. Uses
/// the two low bits of `quarters`.
#[inline]
fn turned_f64(quarters: u64, sine: f64, cosine: f64) -> (f64, f64) {
    let (sine, cosine) = (sine.to_bits(), cosine.to_bits());
    let exchange = (sine ^ cosine) & (quarters & 1).wrapping_neg();
    let sine_sign = (quarters & 2) << 62;
    let cosine_sign = (quarters.wrapping_add(1) & 2) << 62;
    (
        f64::from_bits(sine ^ exchange ^ sine_sign),
        f64::from_bits(cosine ^ exchange ^ cosine_sign),
    )
}
