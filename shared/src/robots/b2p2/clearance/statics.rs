//! Statics of a straight robot with taut belts on one step: the nose lies under the belts, the rear
//! pulleys stand on the ground before the step.
//!
//! ```text
//!                       G
//!              o axle 2   o axle 3        pitch p, pulley radius r
//!            /      ____/
//!     axle 1 o ___/ N----------           N: nose, h above the ground
//!            |  a   |                     a: distance along the belt from below axle 1 to the nose
//!     -------R------+                     R: rear edge
//! ```
//!
//! The belt is at the nose where `r + a sin p - r cos p = h`. The robot gets over the nose if its
//! centre of gravity passes the nose at a pitch that friction can hold.

use crate::math::Scalar;

/// A straight robot on its belts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Straight<S> {
    /// Centre of gravity, m: in front of axle 1 along the body, and above the axles.
    pub cog: [S; 2],
    /// Distance of axle 3 from axle 1, m.
    pub length: S,
    /// Radius of the pulleys, belt included, m.
    pub pulley_radius: S,
}

impl<S: Scalar> Straight<S> {
    /// Returns the largest height, m, of a nose that the centre of gravity passes at this pitch,
    /// rad (0 to below a quarter turn).
    pub fn height(&self, pitch: S) -> S {
        let [x, z] = self.cog;
        let r = self.pulley_radius;
        let (sine, cosine) = pitch.sin_cos();
        (x - (z + r) * sine / cosine) * sine + r * (S::ONE - cosine)
    }

    /// Returns how far the centre of gravity is past a nose of this height, m, at this pitch, rad
    /// (above 0, below a quarter turn), measured along the belt; negative before the nose.
    pub fn past_nose(&self, pitch: S, height: S) -> S {
        let (sine, _) = pitch.sin_cos();
        (self.height(pitch) - height) / sine
    }

    /// Returns the pitch up to `limit`, rad, at which the robot passes the highest nose, and the
    /// height of that nose, m. The resolution is 1/128 rad.
    pub fn highest(&self, limit: S) -> [S; 2] {
        let step = S::from_f64(STEP);
        let (mut pitch, mut best) = (step, [S::ZERO; 2]);
        while pitch <= limit {
            let height = self.height(pitch);
            if height > best[1] {
                best = [pitch, height];
            }
            pitch += step;
        }
        best
    }

    /// Returns the margin, m, with which the robot clears a nose of this height: the largest
    /// [`Self::past_nose`] up to the pitch `limit`, rad, and the pitch at which it occurs.
    pub fn margin(&self, height: S, limit: S) -> [S; 2] {
        let step = S::from_f64(STEP);
        let mut best = [S::from_f64(f64::MIN), S::ZERO];
        let mut pitch = step;
        while pitch <= limit {
            let past = self.past_nose(pitch, height);
            if past > best[0] {
                best = [past, pitch];
            }
            pitch += step;
        }
        best
    }
}

/// Resolution of a pitch, rad.
const STEP: f64 = 1.0 / 128.0;
