//! Cubic polynomials in fixed point, which store a smooth function of an angle in pieces and
//! evaluate it in a few instructions.
//!
//! A piece is `c0 + c1 u + c2 u^2 + c3 u^3`, where `u` runs from -1 to 1 across the piece and is
//! held in Q31. A multiplication by `u` keeps the high word, which has one bit less. So each
//! coefficient has one fraction bit more than the sum to which it is added.

/// Returns the high word of the product: `a b / 2^32`, rounded down. One instruction (SMMUL) on
/// ARM.
#[inline]
pub fn mul_high(a: i32, b: i32) -> i32 {
    #[cfg(target_arch = "arm")]
    {
        let product;
        // SAFETY: one instruction on registers; it touches neither memory nor flags.
        unsafe {
            core::arch::asm!("smmul {}, {}, {}", lateout(reg) product, in(reg) a, in(reg) b,
                options(pure, nomem, nostack, preserves_flags));
        }
        product
    }
    #[cfg(not(target_arch = "arm"))]
    mul_high_plain(a, b)
}

/// Returns `sum + a b / 2^32`, rounded to nearest, wrapping. One instruction (SMMLAR) on ARM.
#[inline]
pub fn mul_high_add(sum: i32, a: i32, b: i32) -> i32 {
    #[cfg(target_arch = "arm")]
    {
        let result;
        // SAFETY: one instruction on registers; it touches neither memory nor flags.
        unsafe {
            core::arch::asm!("smmlar {}, {}, {}, {}", lateout(reg) result, in(reg) a, in(reg) b, in(reg) sum,
                options(pure, nomem, nostack, preserves_flags));
        }
        result
    }
    #[cfg(not(target_arch = "arm"))]
    mul_high_add_plain(sum, a, b)
}

/// Returns `sum - a b / 2^32`, rounded to nearest, wrapping. One instruction (SMMLSR) on ARM.
#[inline]
pub fn mul_high_sub(sum: i32, a: i32, b: i32) -> i32 {
    #[cfg(target_arch = "arm")]
    {
        let result;
        // SAFETY: one instruction on registers; it touches neither memory nor flags.
        unsafe {
            core::arch::asm!("smmlsr {}, {}, {}, {}", lateout(reg) result, in(reg) a, in(reg) b, in(reg) sum,
                options(pure, nomem, nostack, preserves_flags));
        }
        result
    }
    #[cfg(not(target_arch = "arm"))]
    mul_high_sub_plain(sum, a, b)
}

/// Computes [`mul_high`] in plain Rust: the definition against which the instruction is tested.
#[inline]
pub const fn mul_high_plain(a: i32, b: i32) -> i32 {
    ((a as i64 * b as i64) >> 32) as i32
}

/// Computes [`mul_high_add`] in plain Rust.
#[inline]
pub const fn mul_high_add_plain(sum: i32, a: i32, b: i32) -> i32 {
    // A product is at most 2^62, so adding the rounding bit cannot overflow.
    sum.wrapping_add(((a as i64 * b as i64 + (1 << 31)) >> 32) as i32)
}

/// Computes [`mul_high_sub`] in plain Rust.
#[inline]
pub const fn mul_high_sub_plain(sum: i32, a: i32, b: i32) -> i32 {
    // A product is at least -2^62 + 2^31, so subtracting it from the rounding bit cannot overflow.
    sum.wrapping_add((((1 << 31) - a as i64 * b as i64) >> 32) as i32)
}

/// Points at which [`fit`] needs its samples: the roots of the Chebyshev polynomial `T4`, in rising
/// order.
pub const NODES: [f64; 4] = [-OUTER, -INNER, INNER, OUTER];
/// `cos(pi / 8)`.
const OUTER: f64 = 0.923_879_532_511_286_7;
/// `cos(3 pi / 8)`.
const INNER: f64 = 0.382_683_432_365_089_8;

/// Returns the cubic through four samples at [`NODES`], as `[c0, c1, c2, c3]`. Its largest error
/// over the piece is within a few percent of the minimum.
pub const fn fit(samples: [f64; 4]) -> [f64; 4] {
    const INNER_SQUARED: f64 = INNER * INNER;
    const DIFFERENCE: f64 = core::f64::consts::FRAC_1_SQRT_2;
    let [a, b, c, d] = samples;
    let (even_outer, even_inner) = (0.5 * (d + a), 0.5 * (c + b));
    let (odd_outer, odd_inner) = (0.5 * (d - a) / OUTER, 0.5 * (c - b) / INNER);
    let c2 = (even_outer - even_inner) / DIFFERENCE;
    let c3 = (odd_outer - odd_inner) / DIFFERENCE;
    [
        even_inner - c2 * INNER_SQUARED,
        odd_inner - c3 * INNER_SQUARED,
        c2,
        c3,
    ]
}

/// Converts `value` to fixed point with `fractional_bits`, rounded to nearest; saturates.
pub const fn quantize(value: f64, fractional_bits: u32) -> i32 {
    let scaled = value * (1u64 << fractional_bits) as f64;
    (scaled + if scaled < 0.0 { -0.5 } else { 0.5 }) as i32
}

/// Computes the sine of `x`, for tables. Domain: -pi to pi; error below 1e-15. It uses only IEEE
/// sums, products and quotients, so it is bit-identical on every machine.
pub const fn sine(x: f64) -> f64 {
    use core::f64::consts::{FRAC_PI_2, PI};
    let x = if x > FRAC_PI_2 {
        PI - x
    } else if x < -FRAC_PI_2 {
        -PI - x
    } else {
        x
    };
    // Taylor series to x^21, evaluated from the inside out. The next term is below 2e-18.
    let mut sum = 1.0;
    let mut n = 20;
    while n > 0 {
        sum = 1.0 - x * x / ((n * (n + 1)) as f64) * sum;
        n -= 2;
    }
    x * sum
}
