//! Computes the tip-over angles of Papadopoulos and Rey (The Force-Angle Measure of Tipover
//! Stability Margin).
//!
//! Contacts run counter-clockwise seen from above, as everywhere in this project; the papers have
//! them clockwise.

use crate::math::Scalar;
use crate::math::vector::{Vector, add, cross, dot, scale, sub, zero};

/// Angle by which the net force on the centre of gravity is inside each edge of the support, rad,
/// from -pi to pi: positive inside, zero when the robot is about to tip, negative when it tips.
/// Element `k` is the edge from contact `k` to the next one.
///
/// `contacts` and `cog` are in m, `force` in N and `moment` about `cog` in N m, all in one frame.
/// Force and moment are those of gravity, inertia and other external forces, without the reaction
/// of the ground. Let `a` be the direction of the edge, `l` the perpendicular from `cog` to it, and
/// `f* = (1 - a a^T) f + (l/|l| x a a^T m) / |l|` (Papadopoulos and Rey). The angle is the one from
/// `f*` to `l` about `a`. Multiplied by `|a|` and `|l|` it is
/// `atan2(|e| (d x f . e - e . m), |e|^2 d . f - (e . d)(e . f))`, where `e` is the whole edge and
/// `d` its start from `cog`. This form needs no division.
///
/// Besseron et al. (eq. 1) measure to the centre of the edge instead, which is right only where
/// `cog` is opposite to the centre. They also give the angle no sign, so that the margin cannot
/// become negative.
///
/// Domain: any. An edge without length and a force of zero give 0, never "inside". NaN gives NaN.
/// Cost: 51 operations and an arc tangent per edge.
pub fn angles<S: Scalar, const N: usize>(
    contacts: &[Vector<S>; N],
    cog: Vector<S>,
    force: Vector<S>,
    moment: Vector<S>,
) -> [S; N] {
    let mut angles = [S::ZERO; N];
    let followers = contacts.iter().cycle().skip(1);
    for ((angle, from), to) in angles.iter_mut().zip(contacts).zip(followers) {
        let (edge, start) = (sub(*to, *from), sub(*from, cog));
        let square = dot(edge, edge);
        let turning = dot(cross(start, force), edge) - dot(edge, moment);
        let pressing = square * dot(start, force) - dot(edge, start) * dot(edge, force);
        *angle = (square.sqrt() * turning).atan2(pressing);
    }
    angles
}

/// One edge of a support, as seen from the origin of the frame.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Edge<S> {
    /// Direction, of unit length.
    direction: Vector<S>,
    /// Point of the edge's line that is nearest to the origin, m.
    foot: Vector<S>,
    /// `direction x foot`: times a force in the origin, its moment about the edge, m.
    lever: Vector<S>,
}

/// Support whose edges do not change for a while, prepared once; it gives the smallest angle only.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Edges<S, const N: usize>([Edge<S>; N]);

impl<S: Scalar, const N: usize> Edges<S, N> {
    /// Prepares the edges between contacts, counter-clockwise, m. `None` if an edge has no length
    /// or is not finite. Cost: a root and a division per edge.
    pub fn new(contacts: &[Vector<S>; N]) -> Option<Self> {
        let none = Edge {
            direction: zero(),
            foot: zero(),
            lever: zero(),
        };
        let mut edges = [none; N];
        let followers = contacts.iter().cycle().skip(1);
        for ((prepared, from), to) in edges.iter_mut().zip(contacts).zip(followers) {
            let edge = sub(*to, *from);
            let length = dot(edge, edge).sqrt();
            if !(length > S::ZERO && length.is_finite()) {
                return None;
            }
            let direction = scale(S::ONE / length, edge);
            let foot = sub(*from, scale(dot(*from, direction), direction));
            *prepared = Edge {
                direction,
                foot,
                lever: cross(direction, foot),
            };
        }
        Some(Self(edges))
    }

    /// Smallest of the angles that [`angles`] computes from the same inputs, rad. Moves force and
    /// moment to the origin once, and compares the edges by cross-multiplication, so that one arc
    /// tangent is enough.
    ///
    /// Domain: finite inputs in a frame whose origin is in or near the robot. NaN and a support
    /// without edges give NaN. Worst error in single precision 1.5e-6 rad for forces above 30 N
    /// across robots of this size (`shared/tests/stability/tipover.rs`). Cost on Cortex-M4: see
    /// `cargo cost`.
    #[inline]
    pub fn margin(&self, cog: Vector<S>, force: Vector<S>, moment: Vector<S>) -> S {
        let about_origin = add(moment, cross(cog, force));
        let at_cog = dot(cog, force);
        let parts = |edge: &Edge<S>| {
            let turning = dot(edge.lever, force) - dot(edge.direction, about_origin);
            let lengthwise = dot(edge.direction, cog);
            let pressing = dot(edge.foot, force) - at_cog + lengthwise * dot(edge.direction, force);
            (turning, pressing)
        };
        let Some((first, others)) = self.0.split_first() else {
            return S::from_f64(f64::NAN);
        };
        // NaN in an input makes every edge NaN; then the first edge stays selected and the result
        // is NaN.
        let (mut y, mut x) = parts(first);
        let mut tips = y < S::ZERO;
        for edge in others {
            let (turning, pressing) = parts(edge);
            // Whether this angle is the smaller one, if both have the same sign.
            let smaller = pressing * y - turning * x > S::ZERO;
            if turning < S::ZERO {
                if !tips || smaller {
                    (y, x, tips) = (turning, pressing, true);
                }
            } else if !tips && smaller {
                (y, x) = (turning, pressing);
            }
        }
        y.atan2(x)
    }
}

/// Smallest of the angles (Besseron et al., Decoupled control of the high mobility robot Hylos,
/// eq. 1): the stability margin of the robot, rad. NaN if any angle is NaN, or if there is none.
pub fn margin<S: Scalar>(angles: &[S]) -> S {
    let Some((first, others)) = angles.split_first() else {
        return S::from_f64(f64::NAN);
    };
    others.iter().fold(*first, |least, angle| {
        if least < *angle {
            least
        } else if *angle <= least {
            *angle
        } else {
            *angle + least
        }
    })
}
