//! Root, minimum, maximum and limiters for `f32`: defined for every input, with the same bits on every target.
//!
//! `f32::min`, `max` and `clamp` are not used because signed zeros and NaN come out differently on x86-64 and Cortex-M4F.

mod c {
    unsafe extern "C" {
        // IEEE 754 defines this operation to the bit, and the compiler makes it one machine instruction (VSQRT, SQRTSS).
        pub safe fn sqrtf(x: f32) -> f32;
        // The same in double precision (SQRTSD); the nodes compute in single precision and never ask for it.
        pub safe fn sqrt(x: f64) -> f64;
    }
}

/// Square root, correctly rounded. NaN below zero and for NaN; -0 for -0.
#[inline]
pub fn sqrt(value: f32) -> f32 {
    if value >= 0.0 {
        c::sqrtf(value)
    } else {
        f32::NAN
    }
}

/// Square root in double precision, as [`sqrt`].
#[inline]
pub(super) fn sqrt_f64(value: f64) -> f64 {
    if value >= 0.0 {
        c::sqrt(value)
    } else {
        f64::NAN
    }
}

/// [`sqrt`] of a value that is a sum of squares, and so cannot be negative: NaN for NaN, cheaper by the comparison with zero.
#[inline]
pub(crate) fn root_of_sum(squares: f32) -> f32 {
    c::sqrtf(squares)
}

/// The smaller value; -0 is below +0. NaN if either is NaN (IEEE 754-2019 `minimum`): a lost value must not look like a good one.
#[inline]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b {
        a
    } else if b < a {
        b
    } else if a == b {
        // Equal values differ at most in the sign of zero.
        f32::from_bits(a.to_bits() | b.to_bits())
    } else {
        f32::NAN
    }
}

/// The larger value; +0 is above -0. NaN if either is NaN (IEEE 754-2019 `maximum`).
#[inline]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b {
        a
    } else if b > a {
        b
    } else if a == b {
        f32::from_bits(a.to_bits() & b.to_bits())
    } else {
        f32::NAN
    }
}

/// `value` raised to `low`, then lowered to `high` (which wins if they cross). NaN if any is NaN; see [`limit`] for an output that
/// must always be a number.
#[inline]
pub fn clamp(value: f32, low: f32, high: f32) -> f32 {
    min(max(value, low), high)
}

/// `value` kept within `-bound..=bound`: the last gate before an actuator.
///
/// Total: always a number, never beyond the bound. 0 if `value` is NaN, and 0 if `bound` is NaN, zero or negative.
#[inline]
pub fn limit(value: f32, bound: f32) -> f32 {
    // The usual case first. Every comparison with NaN is false and ends in zero.
    if value.abs() <= bound {
        value
    } else if bound > 0.0 {
        if value > 0.0 {
            bound
        } else if value < 0.0 {
            -bound
        } else {
            0.0
        }
    } else {
        0.0
    }
}

/// `value` without its fraction; saturates, 0 for NaN.
#[inline]
pub fn to_i32(value: f32) -> i32 {
    value as i32
}

/// As [`to_i32`], saturating at the ends of `i16`.
#[inline]
pub fn to_i16(value: f32) -> i16 {
    to_i32(value).clamp(i16::MIN.into(), i16::MAX.into()) as i16
}

/// `value` as far as 32 bits go.
#[inline]
pub fn saturate(value: i64) -> i32 {
    let low = value as i32;
    if i64::from(low) == value {
        low
    } else {
        i32::MAX ^ (value >> 63) as i32
    }
}

/// A limit of both signs in fixed point that is only known at run time. The core has no instruction for it (SSAT wants a power of two), but
/// its sums that saturate (QADD, QSUB) do it in four, without a comparison.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Bound {
    /// From the limit up to the end of the integers.
    headroom: i32,
}

impl Bound {
    /// Limits to `-bound - 1..=bound`; a negative bound counts as 0.
    #[inline]
    pub const fn new(bound: i32) -> Self {
        Self {
            headroom: i32::MAX - if bound > 0 { bound } else { 0 },
        }
    }

    /// `value` within the bound.
    #[inline]
    pub const fn limit(self, value: i32) -> i32 {
        let not_above = value
            .saturating_add(self.headroom)
            .wrapping_sub(self.headroom);
        not_above
            .saturating_sub(self.headroom)
            .wrapping_add(self.headroom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_is_the_clamp_of_integers() {
        let edges = [
            i32::MIN,
            i32::MIN + 1,
            -70_000,
            -5,
            -1,
            0,
            1,
            5,
            70_000,
            i32::MAX - 1,
            i32::MAX,
        ];
        for bound in edges {
            let limit = Bound::new(bound);
            let bound = bound.max(0);
            for near in [0, bound, -bound].into_iter().chain(edges) {
                for value in (-3..=3).map(|offset| near.saturating_add(offset)) {
                    assert_eq!(
                        limit.limit(value),
                        value.clamp(-bound - 1, bound),
                        "{value} {bound}"
                    );
                }
            }
        }
    }
}
