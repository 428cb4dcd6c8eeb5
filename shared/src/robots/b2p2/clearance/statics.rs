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

use super::Phase;
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

    /// Returns how the robot clears a curb of this height, m, with this coefficient of friction.
    pub fn curb(&self, height: S, friction: S) -> Clearing<S> {
        let slips = friction.atan2(S::ONE);
        let given_up = S::from_f64(GIVEN_UP);
        let limit = if slips < given_up { slips } else { given_up };
        let step = S::from_f64(STEP);
        let mut best = Clearing {
            margin: S::from_f64(-1.0),
            pitch: S::ZERO,
            phase: Phase::Mount,
        };
        let mut pitch = step;
        while pitch <= limit {
            let margin = self.past_nose(pitch, height);
            if margin > best.margin {
                best = Clearing {
                    margin,
                    pitch,
                    ..best
                };
            }
            pitch += step;
        }
        best
    }

    /// Returns how the robot clears stairs with this riser and run, m.
    ///
    /// Each step is a curb: the rear pulleys stand on the tread before it. On all noses friction
    /// holds the robot, and the front reaches the next nose when the centre of gravity passes one.
    pub fn stairs(&self, riser: S, run: S, friction: S) -> Clearing<S> {
        let step = self.curb(riser, friction);
        let slope = riser.atan2(run);
        let on_noses = Clearing {
            margin: (friction - riser / run) * S::from_f64(PER_FRICTION),
            pitch: slope,
            phase: Phase::Climb,
        };
        let next = Clearing {
            margin: self.length - self.cog[0] - (riser * riser + run * run).sqrt(),
            pitch: slope,
            phase: Phase::Sway,
        };
        step.or_narrower(on_noses).or_narrower(next)
    }
}

/// Whether and how a robot clears an obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearing<S> {
    /// Margin, m, from -1 m on: at a nose the distance of the centre of gravity past it, in sways
    /// the distance by which the front reaches beyond the next nose, on noses 0.1 m for each unit
    /// of friction that is left. Below 0 the robot does not clear the obstacle.
    pub margin: S,
    /// Pitch at which the margin occurs, rad.
    pub pitch: S,
    /// Phase with this margin, the critical one: [`Phase::Mount`], [`Phase::Climb`] or
    /// [`Phase::Sway`].
    pub phase: Phase,
}

impl<S: Scalar> Clearing<S> {
    /// Returns the one with the narrower margin.
    fn or_narrower(self, other: Self) -> Self {
        if other.margin < self.margin {
            other
        } else {
            self
        }
    }
}

/// Resolution of a pitch, rad.
const STEP: f64 = 1.0 / 128.0;
/// Margin that a unit of friction counts as, m.
const PER_FRICTION: f64 = 0.1;
/// Pitch at which the controller gives an obstacle up, rad, if that of the robot's highest nose is
/// not below it.
pub const GIVEN_UP: f64 = 0.87;
