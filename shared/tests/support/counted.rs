//! A scalar that counts what is done with it.

use std::cell::Cell;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};
use tautrack::math::Scalar;

thread_local! {
    static OPERATIONS: Cell<u32> = const { Cell::new(0) };
}

/// Double precision that counts sums, differences, products, quotients and roots; signs are free,
/// and sines are for the caller.
#[derive(Clone, Copy, PartialEq, PartialOrd, Debug)]
pub struct Counted(f64);

/// Operations that `work` does.
pub fn operations<R>(work: impl FnOnce() -> R) -> u32 {
    OPERATIONS.set(0);
    std::hint::black_box(work());
    OPERATIONS.get()
}

fn count(value: f64) -> Counted {
    OPERATIONS.set(OPERATIONS.get() + 1);
    Counted(value)
}

impl Add for Counted {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        count(self.0 + other.0)
    }
}

impl Sub for Counted {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        count(self.0 - other.0)
    }
}

impl Mul for Counted {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        count(self.0 * other.0)
    }
}

impl Div for Counted {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        count(self.0 / other.0)
    }
}

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl AddAssign for Counted {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Scalar for Counted {
    const ZERO: Self = Self(0.0);
    const ONE: Self = Self(1.0);

    fn from_f64(value: f64) -> Self {
        Self(value)
    }
    fn to_f64(self) -> f64 {
        self.0
    }
    fn is_finite(self) -> bool {
        self.0.is_finite()
    }
    fn sqrt(self) -> Self {
        count(Scalar::sqrt(self.0))
    }
    fn sin_cos(self) -> (Self, Self) {
        let (sine, cosine) = Scalar::sin_cos(self.0);
        (Self(sine), Self(cosine))
    }
    fn atan2(self, x: Self) -> Self {
        Self(Scalar::atan2(self.0, x.0))
    }
}
