//! Sine and cosine of a binary angle from one table of cubics, and the arc tangent of two
//! coordinates.

use super::cubic::{NODES, fit, mul_high_add, quantize, sine};
use crate::units::Angle;
use core::f32::consts::{FRAC_PI_2, PI};

/// Number of pieces over the full circle. Each piece is centred on a multiple of its width, so that
/// sine is exactly 0 at 0.
const PIECES: usize = 64;
/// Bits of an angle within a piece.
const PIECE_BITS: u32 = 26;
/// Pieces of a quarter turn. The cosine is the sine of so many pieces later.
const QUARTER: usize = PIECES / 4;

/// The circle and a quarter turn more, so that the cosine needs no index of its own.
static SINE: [[i32; 4]; PIECES + QUARTER] = sine_table();

const fn sine_table() -> [[i32; 4]; PIECES + QUARTER] {
    const HALF_WIDTH: f64 = core::f64::consts::PI / PIECES as f64;
    let mut table = [[0; 4]; PIECES + QUARTER];
    let mut piece = 0;
    while piece < table.len() {
        let turns = if piece < PIECES / 2 {
            0.0
        } else {
            PIECES as f64
        };
        let centre = (piece as f64 - turns) * 2.0 * HALF_WIDTH;
        let mut samples = [0.0; 4];
        let mut node = 0;
        while node < 4 {
            let x = centre + NODES[node] * HALF_WIDTH;
            // The piece around half a turn extends beyond half a turn.
            let full = 2.0 * core::f64::consts::PI;
            samples[node] = sine(if x < -core::f64::consts::PI {
                x + full
            } else {
                x
            });
            node += 1;
        }
        let [c0, c1, c2, c3] = fit(samples);
        table[piece] = [
            quantize(c0, 30),
            quantize(c1, 31),
            quantize(c2, 32),
            quantize(c3, 33),
        ];
        piece += 1;
    }
    table
}

/// Returns sine and cosine with 30 fraction bits: 2^30 is one.
///
/// Domain: every `Angle`. Worst error over all angles: 3.14e-8 (`shared/tests/math/functions.rs`,
/// `sine_and_cosine_keep_their_errors_over_every_angle`). No result exceeds one. The sine of 0 and
/// the cosine of a quarter turn are exactly 0. Cost on Cortex-M4: 30 instructions as a function.
#[inline]
pub fn sin_cos_q30(angle: Angle) -> (i32, i32) {
    let bits = angle.to_bits();
    let piece = (bits.wrapping_add(1 << (PIECE_BITS - 1)) as u32 >> PIECE_BITS) as usize;
    let u = bits << (32 - PIECE_BITS);
    let evaluate = |[c0, c1, c2, c3]: [i32; 4]| {
        mul_high_add(c0, u, mul_high_add(c1, u, mul_high_add(c2, u, c3)))
    };
    // A quarter turn is a whole number of pieces. So cosine is sine with the same `u`.
    let piece = piece % PIECES;
    (evaluate(SINE[piece]), evaluate(SINE[piece + QUARTER]))
}

/// Returns sine and cosine in single precision.
///
/// Domain: every `Angle`. Worst error over all angles: 6.2e-8, by the same test as [`sin_cos_q30`].
#[inline]
pub fn sin_cos(angle: Angle) -> (f32, f32) {
    const ONE: f32 = (1 << 30) as f32;
    let (sin, cos) = sin_cos_q30(angle);
    (sin as f32 / ONE, cos as f32 / ONE)
}

/// Coefficients of `atan(t) / t` in powers of `t^2` for `t` from 0 to 1, interpolated at Chebyshev
/// nodes. The error is 1e-8 before rounding.
const ARC_TANGENT: [f32; 9] = [
    1.0,
    -0.333_330_36,
    0.199_918_72,
    -0.141_977_98,
    0.106_183_71,
    -0.074_568_55,
    0.042_137_623,
    -0.015_731_25,
    0.002_766_283_5,
];

/// Returns the direction of the point (`x`, `y`) in radians, from -pi to pi.
///
/// It is defined for every input as in IEEE 754. The origin gives 0, or pi if `x` is -0, with the
/// sign of `y`. An infinite coordinate wins over a finite one; two infinite coordinates give a
/// diagonal. NaN gives NaN, and it is always the same NaN. Worst error seen: 2.1e-7 rad; bound:
/// 4e-7 rad (`shared/tests/math/functions.rs`, `arc_tangent_*`).
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    if x.is_nan() || y.is_nan() {
        return f32::NAN;
    }
    let (across, along) = (y.abs(), x.abs());
    let steep = across > along;
    let (low, high) = if steep {
        (along, across)
    } else {
        (across, along)
    };
    let ratio = if low == 0.0 {
        0.0
    } else if low == high {
        1.0
    } else {
        low / high
    };
    let square = ratio * ratio;
    let sum = ARC_TANGENT
        .iter()
        .rev()
        .fold(0.0, |sum, c| sum * square + c);
    let octant = ratio * sum;
    let quadrant = if steep { FRAC_PI_2 - octant } else { octant };
    let half = if x.is_sign_negative() {
        PI - quadrant
    } else {
        quadrant
    };
    half.copysign(y)
}

/// Computes [`atan2`] in double precision. Worst error: 9e-16 rad (`shared/tests/math/scalar.rs`).
pub(super) fn atan2_f64(y: f64, x: f64) -> f64 {
    use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
    /// Tangent of a sixteenth of a turn. Above it, the angle to the diagonal is the smaller one.
    const TAN_PI_8: f64 = 0.414_213_562_373_095_05;
    /// Number of terms of the Taylor series. The first omitted term is below 1e-17 at `TAN_PI_8`.
    const TERMS: u32 = 21;

    if x.is_nan() || y.is_nan() {
        return f64::NAN;
    }
    let (across, along) = (y.abs(), x.abs());
    let steep = across > along;
    let (low, high) = if steep {
        (along, across)
    } else {
        (across, along)
    };
    let ratio = if low == 0.0 {
        0.0
    } else if low == high {
        1.0
    } else {
        low / high
    };
    let (base, tangent) = if ratio > TAN_PI_8 {
        (FRAC_PI_4, (ratio - 1.0) / (ratio + 1.0))
    } else {
        (0.0, ratio)
    };
    let mut sum = 0.0;
    for term in (0..TERMS).rev() {
        sum = 1.0 / f64::from(2 * term + 1) - tangent * tangent * sum;
    }
    let octant = base + tangent * sum;
    let quadrant = if steep { FRAC_PI_2 - octant } else { octant };
    let half = if x.is_sign_negative() {
        PI - quadrant
    } else {
        quadrant
    };
    half.copysign(y)
}
