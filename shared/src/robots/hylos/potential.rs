//! Computes the stability potential of Besseron et al. from the tip-over angles.

use crate::math::Scalar;

/// Why constants give no valid potential.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum PotentialError {
    /// The gain is negative or not finite.
    Gain(f64),
    /// The angles do not satisfy `1e-6 <= floor <= limit`, or are not finite.
    Angles {
        /// Angle below which the potential continues as a straight line, rad.
        floor: f64,
        /// Angle above which the potential is zero, rad.
        limit: f64,
    },
}

/// Potential that raises the tip-over angles (Besseron et al., eq. 4 and 5): `k/2 (1/nu - 1/nu*)^2`
/// of each angle below the limit `nu*`.
///
/// The printed form is infinite at `nu = 0`, and below zero it pushes the robot over. Here the
/// potential continues below a floor as its own tangent.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Potential<S> {
    gain: S,
    limit: S,
    per_limit: S,
    floor: S,
    at_floor: S,
    slope_at_floor: S,
}

impl<S: Scalar> Potential<S> {
    /// Potential with gain `k_stab`, limit `nu*` and floor `nu_min`, rad.
    ///
    /// # Errors
    /// If the gain is negative, or not `1e-6 <= floor <= limit`, or a value is not finite.
    pub fn new(gain: f64, limit: f64, floor: f64) -> Result<Self, PotentialError> {
        if !(gain >= 0.0 && gain.is_finite()) {
            return Err(PotentialError::Gain(gain));
        }
        // Below a millionth of a radian the square of the reciprocal leaves the range of an `f32`
        // sum.
        if !(floor >= 1e-6 && floor <= limit && limit.is_finite()) {
            return Err(PotentialError::Angles { floor, limit });
        }
        let excess = 1.0 / floor - 1.0 / limit;
        Ok(Self {
            gain: S::from_f64(gain),
            limit: S::from_f64(limit),
            per_limit: S::from_f64(1.0 / limit),
            floor: S::from_f64(floor),
            at_floor: S::from_f64(0.5 * gain * excess * excess),
            slope_at_floor: S::from_f64(-gain * excess / (floor * floor)),
        })
    }

    /// Potential of one angle and its derivative, 1/rad. NaN for NaN.
    pub fn of_angle(&self, angle: S) -> (S, S) {
        if angle > self.limit {
            (S::ZERO, S::ZERO)
        } else if angle >= self.floor {
            let reciprocal = S::ONE / angle;
            let excess = reciprocal - self.per_limit;
            let push = self.gain * excess;
            (
                S::from_f64(0.5) * push * excess,
                -(push * reciprocal * reciprocal),
            )
        } else {
            let below = angle - self.floor;
            (
                self.at_floor + self.slope_at_floor * below,
                self.slope_at_floor,
            )
        }
    }

    /// Potential of all angles (eq. 4).
    pub fn total(&self, angles: &[S]) -> S {
        angles
            .iter()
            .fold(S::ZERO, |sum, angle| sum + self.of_angle(*angle).0)
    }
}
