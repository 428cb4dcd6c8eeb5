//! Computes the table of a geometry in integers. It is meant for start-up. The routines of double
//! precision would take 2.5 KB of a motor board's flash memory, and nothing else needs them.
//!
//! All values are 64-bit integers with [`FRACTION`] fraction bits. The table is bit-identical on
//! every machine.

use super::{EXTRA_BITS, PIECES};
use crate::math::cubic::NODES;
use crate::units::Length;
use core::f64::consts::{FRAC_PI_2, PI, SQRT_2};

/// Fraction bits. The largest value is `K^2` = 16 m^2, which leaves a bit besides the sign.
const FRACTION: u32 = 58;
const ONE: i64 = 1 << FRACTION;
/// Half of the width of a piece, rad.
const HALF_WIDTH: f64 = PI / (2 * PIECES) as f64;

/// Computes the extension over half a turn as cubics, with coefficients scaled as
/// [`crate::math::cubic`] needs them. The geometry is accepted.
pub(super) fn fill(pieces: &mut [[i32; 4]; PIECES], l1: Length, l2: Length, k: Length) {
    const Q: u32 = Length::FRAC_NBITS;
    // A shift rounds down. With half a bit in the constant term it rounds to nearest.
    const HALF_BIT: i64 = 1 << (FRACTION - Q - 1);
    const OFFSETS: [i64; 4] = [
        constant(NODES[0] * HALF_WIDTH),
        constant(NODES[1] * HALF_WIDTH),
        constant(NODES[2] * HALF_WIDTH),
        constant(NODES[3] * HALF_WIDTH),
    ];
    let [l1, l2, k] = [l1, l2, k].map(|length| i64::from(length.to_bits()) << (FRACTION - Q));
    let squares = product(k, k) - product(l1, l1);
    let mut centre = constant(HALF_WIDTH);
    for piece in pieces {
        let samples = OFFSETS.map(|offset| {
            let cosine = sine(constant(FRAC_PI_2) - (centre + offset));
            quotient(squares, 2 * (k + product(l1, cosine))) - l2
        });
        let [c0, c1, c2, c3] = fit(samples);
        *piece = [
            rounded(c0 + HALF_BIT, Q),
            rounded(c1, Q + 1 + EXTRA_BITS),
            rounded(c2, Q + 2 + EXTRA_BITS),
            rounded(c3, Q + 3 + EXTRA_BITS),
        ];
        centre += 2 * constant(HALF_WIDTH);
    }
}

/// Converts a constant below 32.
const fn constant(value: f64) -> i64 {
    (value * ONE as f64) as i64
}

/// Returns `a b`, rounded down.
#[inline(never)] // each inlined copy takes 100 bytes
fn product(a: i64, b: i64) -> i64 {
    ((i128::from(a) * i128::from(b)) >> FRACTION) as i64
}

/// Returns `a / b`, rounded down. `a` is from 0 to 16, `b` is above 0 and below 16,
/// and the result is below 16.
fn quotient(a: i64, b: i64) -> i64 {
    let mut result = a.checked_div(b).unwrap_or_default();
    let mut rest = a - result * b;
    for _ in 0..FRACTION {
        (result, rest) = (result << 1, rest << 1);
        if rest >= b {
            rest -= b;
            result += 1;
        }
    }
    result
}

/// Returns the sine of `x`, which is between -pi / 2 and pi / 2 rad, with an error below 1e-16.
fn sine(x: i64) -> i64 {
    let square = product(x, x);
    // Taylor series to x^21, evaluated from the inside out. The next term is below 2e-18.
    let mut sum = ONE;
    let mut n = 20;
    while n > 0 {
        sum = ONE - product(square, sum) / (n * (n + 1));
        n -= 2;
    }
    product(x, sum)
}

/// Returns the cubic through four samples, as [`crate::math::cubic::fit`] does.
fn fit([a, b, c, d]: [i64; 4]) -> [i64; 4] {
    const INNER_SQUARED: i64 = constant(NODES[2] * NODES[2]);
    let (even_outer, even_inner) = ((d + a) >> 1, (c + b) >> 1);
    let odd_outer = product(d - a, constant(0.5 / NODES[3]));
    let odd_inner = product(c - b, constant(0.5 / NODES[2]));
    let c2 = product(even_outer - even_inner, constant(SQRT_2));
    let c3 = product(odd_outer - odd_inner, constant(SQRT_2));
    [
        even_inner - product(c2, INNER_SQUARED),
        odd_inner - product(c3, INNER_SQUARED),
        c2,
        c3,
    ]
}

/// Converts to `fraction_bits`, rounded to nearest. The coefficients of an accepted geometry fit.
fn rounded(value: i64, fraction_bits: u32) -> i32 {
    (((value >> (FRACTION - 1 - fraction_bits)) + 1) >> 1) as i32
}
