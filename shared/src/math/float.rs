//! Square root, minimum, maximum and limiters for `f32`. They are defined for every input and
//! bit-identical on every target.
//!
//! `f32::min`, `max` and `clamp` are not used, because their results for signed zeros and NaN
//! differ between x86-64 and Cortex-M4F.

mod c {
    unsafe extern "C" {
        // IEEE 754 defines every bit of this operation. The compiler makes it one machine
        // instruction (VSQRT, SQRTSS).
        pub safe fn sqrtf(x: f32) -> f32;
        // The same in double precision (SQRTSD). The nodes compute in single precision and never
        // use it.
        pub safe fn sqrt(x: f64) -> f64;
    }
}

/// Returns the square root, correctly rounded. NaN below zero and for NaN; -0 for -0.
#[inline]
pub fn sqrt(value: f32) -> f32 {
    if value >= 0.0 {
        c::sqrtf(value)
    } else {
        f32::NAN
    }
}

/// Returns the square root in double precision, as [`sqrt`] does.
#[inline]
pub(super) fn sqrt_f64(value: f64) -> f64 {
    if value >= 0.0 {
        c::sqrt(value)
    } else {
        f64::NAN
    }
}

/// Computes [`sqrt`] of a sum of squares, which cannot be negative. NaN for NaN. It is cheaper than
/// [`sqrt`], because it needs no comparison with zero.
#[inline]
pub(crate) fn root_of_sum(squares: f32) -> f32 {
    c::sqrtf(squares)
}

/// Returns the smaller value; -0 is below +0. NaN if either value is NaN (IEEE 754-2019 `minimum`),
/// so that an invalid value never looks like a valid one.
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

/// Returns the larger value; +0 is above -0. NaN if either value is NaN (IEEE 754-2019 `maximum`).
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

/// Raises `value` to `low`, then lowers it to `high`, which wins if the two cross. NaN if any of
/// the three is NaN. Use [`limit`] for an output that must never be NaN.
#[inline]
pub fn clamp(value: f32, low: f32, high: f32) -> f32 {
    min(max(value, low), high)
}

/// Limits `value` to `-bound..=bound`.
///
/// It is defined for every input. The result is never NaN and never beyond the bound. It is 0 if
/// `value` is NaN, and 0 if `bound` is NaN, zero or negative.
#[inline]
pub fn limit(value: f32, bound: f32) -> f32 {
    // The usual case comes first. Every comparison with NaN is false, so NaN ends in zero.
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

/// Converts `value` to an integer without its fraction. Saturates; 0 for NaN.
#[inline]
pub fn to_i32(value: f32) -> i32 {
    value as i32
}

/// Converts as [`to_i32`], but saturates at the ends of `i16`.
#[inline]
pub fn to_i16(value: f32) -> i16 {
    to_i32(value).clamp(i16::MIN.into(), i16::MAX.into()) as i16
}

/// Converts `value` to 32 bits; saturates.
#[inline]
pub fn saturate(value: i64) -> i32 {
    let low = value as i32;
    if i64::from(low) == value {
        low
    } else {
        i32::MAX ^ (value >> 63) as i32
    }
}

/// Symmetric limit in fixed point that is known only at run time.
///
/// The core has no instruction for it, because SSAT needs a power of two. Its saturating sums
/// (QADD, QSUB) do it in four instructions, without a comparison.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Bound {
    /// Distance from the limit to the largest integer.
    headroom: i32,
}

impl Bound {
    /// Creates a limit to `-bound - 1..=bound`. A negative bound counts as 0.
    #[inline]
    pub const fn new(bound: i32) -> Self {
        Self {
            headroom: i32::MAX - if bound > 0 { bound } else { 0 },
        }
    }

    /// Creates a limit to the size of `value`: to `-value - 1..=value`, or to `value..=-value - 1`
    /// if it is negative.
    #[inline]
    pub const fn of_size(value: i32) -> Self {
        Self {
            headroom: i32::MAX ^ value ^ (value >> 31),
        }
    }

    /// Limits `value` to the bound.
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
                    assert_eq!(Bound::of_size(bound), limit);
                    assert_eq!(Bound::of_size(-bound - 1), limit);
                }
            }
        }
    }
}
