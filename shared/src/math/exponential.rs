//! Decaying exponentials for any [`Scalar`].

use super::scalar::Scalar;

/// `1 / (n + 1)` for each index n. It is a table, because no tick may divide in double precision.
pub(crate) const RECIPROCALS: [f64; 15] = {
    let mut table = [1.0; 15];
    let mut n = 1;
    while n < table.len() {
        table[n] = 1.0 / (n + 1) as f64;
        n += 1;
    }
    table
};

/// Computes `1 - e^-x`.
///
/// Domain: every `x` from 0 to infinity; 0 below 0; NaN for NaN. Worst error: 2 units in the last
/// place (`shared/tests/robots/crawler_model.rs`, `decays_are_those_of_the_host_s_library`).
/// Cost: at most seven halvings and one series.
pub fn rise<S: Scalar>(x: S) -> S {
    // From this `x` on, the result is 1 in both precisions.
    const ALL: f64 = 40.0;
    let (half, all) = (S::from_f64(0.5), S::from_f64(ALL));
    if x <= S::ZERO {
        return S::ZERO;
    }
    let mut rest = if x > all { all } else { x };
    let mut halvings = 0;
    while rest > half {
        rest = rest * half;
        halvings += 1;
    }
    let mut sum = S::ONE;
    for reciprocal in RECIPROCALS.into_iter().skip(1).rev() {
        sum = S::ONE - sum * rest * S::from_f64(reciprocal);
    }
    let mut rise = rest * sum;
    for _ in 0..halvings {
        // This is 1 - (1 - rise)^2 as a sum of products that are not negative.
        rise = rise + rise * (S::ONE - rise);
    }
    rise
}

/// Computes the mean of `e^-t` for `t` from 0 to `x`: `(1 - e^-x) / x`, and 1 at 0. Domain and
/// error are those of [`rise`].
pub fn mean_decay<S: Scalar>(x: S) -> S {
    if x <= S::ZERO { S::ONE } else { rise(x) / x }
}
