//! Computes the motion of joint 8 that taut tracks require: position, rate and acceleration from
//! those of joint 7.

use crate::math::Scalar;

/// The belt is hardly longer than the robot's rear part, so that nothing can tighten it near half a
/// turn of the chassis joint.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct BeltTooShort {
    /// Belt constant `K`, m.
    pub got: f64,
    /// Smallest accepted value, `1.001 L1`, m.
    pub minimum: f64,
}

/// Belt of constant `K` around the three axles, `L + (L2 + L3) = K` (Paillat et al., eq. 1).
///
/// This is the closed form in floating point, with the second derivative that accelerations need.
/// The screw itself is driven by the faster [`crate::screw::Geometry`], in fixed point.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct TautBelt<S> {
    k: S,
    l1: S,
    l2: S,
}

/// Extension `L3` of the screw as a function of the chassis angle.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Extension<S> {
    /// Distance `r = L2 + L3` between axles 2 and 3, m.
    pub reach: S,
    /// `L3`, m.
    pub length: S,
    /// `dL3 / dtheta`, m/rad.
    pub derivative: S,
    /// `d^2 L3 / dtheta^2`, m/rad^2.
    pub second_derivative: S,
}

impl<S: Scalar> TautBelt<S> {
    /// Belt with the constant `k`, the distance `l1` between axles 1 and 2, and the fixed part `l2`
    /// of the front, m.
    ///
    /// # Errors
    /// If `k` is below `1.001 l1` or not above zero, or a value is not finite.
    pub fn new(k: f64, l1: f64, l2: f64) -> Result<Self, BeltTooShort> {
        let minimum = 1.001 * l1.abs();
        if !(k >= minimum && k > 0.0 && k.is_finite() && l2.is_finite()) {
            return Err(BeltTooShort { got: k, minimum });
        }
        Ok(Self {
            k: S::from_f64(k),
            l1: S::from_f64(l1),
            l2: S::from_f64(l2),
        })
    }

    /// Extension at chassis angle `theta`, rad: `r = (K^2 - L1^2) / (2 (K + L1 cos theta))`
    /// (eq. 2), and with `u = K + L1 cos theta` its derivatives `dL3 = r L1 sin / u`,
    /// `d2L3 = r L1 cos / u + 2 r (L1 sin / u)^2`.
    ///
    /// The bars around theta in eq. 2 change nothing, because the cosine is even.
    pub fn extension(&self, theta: S) -> Extension<S> {
        let (sine, cosine) = theta.sin_cos();
        let (k, l1, two) = (self.k, self.l1, S::from_f64(2.0));
        // At least K - L1, which is above zero in either precision.
        let per_u = S::ONE / (k + l1 * cosine);
        let reach = (k - l1) * (k + l1) * per_u / two;
        let slope = l1 * sine * per_u;
        Extension {
            reach,
            length: reach - self.l2,
            derivative: reach * slope,
            second_derivative: reach * (l1 * cosine * per_u + two * slope * slope),
        }
    }
}
