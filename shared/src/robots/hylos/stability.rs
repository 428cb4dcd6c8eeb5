//! Computes the tip-over angles of Hylos and the total gradient of its stability potential.

use super::least_squares::LeastSquares;
use super::posture::Posture;
use super::{LEGS, Legs, Potential};
use crate::math::Scalar;
use crate::math::vector::{Vector, add, cross, dot, scale, sub, zero};
use crate::stability::tipover::angles;

/// Wheels counter-clockwise seen from above, starting with the rear right one. Tip-over axis `k`
/// runs from `AROUND[k]` to the next.
pub const AROUND: [usize; LEGS] = [3, 1, 0, 2];

/// Force and moment on the centre of gravity, in the platform's axes: gravity, inertia and other
/// external forces, without the reaction of the ground.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Pull<S> {
    /// Force, N.
    pub force: Vector<S>,
    /// Moment about the centre of gravity, N m.
    pub moment: Vector<S>,
}

/// Derivatives of the stability potential.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Gradient<S> {
    /// By the leg joints while the platform keeps its attitude and the wheels leave the ground,
    /// 1/rad.
    pub partial: Legs<S>,
    /// By the platform's height, roll and pitch; the first is always zero.
    pub attitude: Vector<S>,
    /// By the leg joints while the wheels stay on the ground, so that the platform follows eq. 17,
    /// 1/rad.
    pub total: Legs<S>,
}

impl<S: Scalar> Posture<'_, S> {
    /// Centre of gravity and contacts along level axes (x along the heading, z up) from the
    /// platform's middle, m. The contacts run counter-clockwise from the rear right one. Requires a
    /// posture that was made with [`super::Attitude::from_up`].
    pub fn level(&self) -> (Vector<S>, [Vector<S>; LEGS]) {
        let turned = |place| self.attitude.frame.direction(place);
        (
            turned(self.cog),
            AROUND.map(|leg| turned(self.wheels[leg].contact)),
        )
    }

    /// Force of gravity alone.
    pub fn weight(&self) -> Pull<S> {
        let weight = self.parameters.mass * self.parameters.gravity;
        Pull {
            force: scale(-weight, self.attitude.up()),
            moment: zero(),
        }
    }

    /// Tip-over angles (eq. 1, signed) about the axes right, front, left and rear, rad
    /// ([`angles`]).
    pub fn tip_over_angles(&self, pull: &Pull<S>) -> [S; LEGS] {
        let contacts = AROUND.map(|leg| self.wheels[leg].contact);
        angles(&contacts, self.cog, pull.force, pull.moment)
    }

    /// Derivatives of `potential` at these tip-over angles. The margin rises along MINUS the total
    /// one.
    ///
    /// Besseron et al. (eq. 20) move the legs along plus the gradient. That suits the partial
    /// gradient, where wheels move under a platform that keeps its attitude, and even then only in
    /// most cases. On the ground the platform moves against its legs. With the total gradient,
    /// minus always raises the margin. Axes above the limit are skipped.
    pub fn gradient(
        &self,
        potential: &Potential<S>,
        pull: &Pull<S>,
        tip_over: &[S; LEGS],
    ) -> Gradient<S> {
        let slopes = tip_over.map(|angle| potential.of_angle(angle).1);
        self.descent(slopes, pull, &self.follower())
    }

    /// Equations by which the platform's height, roll and pitch follow the wheels: `nL_p` of
    /// eq. 17.
    pub(super) fn follower(&self) -> LeastSquares<S> {
        let up = self.attitude.up();
        LeastSquares::new(self.wheels.map(|wheel| {
            let moment = cross(wheel.contact, wheel.normal);
            let [roll, pitch] = self.attitude.about_roll_and_pitch(moment);
            [dot(up, wheel.normal), roll, pitch]
        }))
    }

    /// Computes [`Self::gradient`] of a potential with these slopes over the tip-over angles, by
    /// the chain rule backward: from the angles to positions and forces, and from these to legs and
    /// attitude.
    pub(super) fn descent(
        &self,
        slopes: [S; LEGS],
        pull: &Pull<S>,
        follower: &LeastSquares<S>,
    ) -> Gradient<S> {
        let mut by_contact = [zero(); LEGS];
        let (mut by_cog, mut by_force, mut by_moment) = (zero(), zero(), zero());
        for (k, slope) in slopes.into_iter().enumerate() {
            if slope == S::ZERO {
                continue;
            }
            let (from, to) = (AROUND[k], AROUND[(k + 1) % LEGS]);
            let start = sub(self.wheels[from].contact, self.cog);
            let edge = sub(self.wheels[to].contact, self.wheels[from].contact);
            let by = AngleDerivatives::new(edge, start, pull, slope);
            by_contact[to] = add(by_contact[to], by.edge);
            by_contact[from] = add(by_contact[from], sub(by.start, by.edge));
            by_cog = sub(by_cog, by.start);
            by_force = add(by_force, by.force);
            by_moment = add(by_moment, by.moment);
        }

        // When the platform turns, the pull turns backward in its axes, and the contacts roll
        // around their wheels.
        let mut by_turning = add(cross(by_force, pull.force), cross(by_moment, pull.moment));
        for (wheel, by) in self.wheels.iter().zip(by_contact) {
            let around = wheel.stretch * dot(by, wheel.tangent);
            by_turning = add(by_turning, scale(around, wheel.lateral));
        }
        let [roll, pitch] = self.attitude.about_roll_and_pitch(by_turning);
        let attitude = [S::ZERO, roll, pitch];

        let shared = scale(self.parameters.wheel_share, by_cog);
        let lifting = follower.solve_transposed(attitude);
        let mut gradient = Gradient {
            partial: [[S::ZERO; 2]; LEGS],
            attitude,
            total: [[S::ZERO; 2]; LEGS],
        };
        for (leg, wheel) in self.wheels.iter().enumerate() {
            let by_hub = add(by_contact[leg], shared);
            gradient.partial[leg] = wheel.along(by_hub);
            gradient.total[leg] = wheel.along(sub(by_hub, scale(lifting[leg], wheel.normal)));
        }
        gradient
    }
}

/// Derivatives of one tip-over angle, times a slope, by the inputs from which [`angles`] computes
/// it.
struct AngleDerivatives<S> {
    edge: Vector<S>,
    start: Vector<S>,
    force: Vector<S>,
    moment: Vector<S>,
}

impl<S: Scalar> AngleDerivatives<S> {
    /// The angle is `atan2(|e| turning, pressing)`. An edge without length, or a force of zero, has
    /// no angle: all derivatives are zero.
    fn new(edge: Vector<S>, start: Vector<S>, pull: &Pull<S>, slope: S) -> Self {
        let (force, moment) = (pull.force, pull.moment);
        let square = dot(edge, edge);
        let length = square.sqrt();
        let by_edge = sub(cross(start, force), moment);
        let turning = dot(by_edge, edge);
        let (start_force, edge_start, edge_force) =
            (dot(start, force), dot(edge, start), dot(edge, force));
        let pressing = square * start_force - edge_start * edge_force;
        let rising = length * turning;
        let whole = rising * rising + pressing * pressing;
        if !(whole > S::ZERO) {
            return Self {
                edge: zero(),
                start: zero(),
                force: zero(),
                moment: zero(),
            };
        }
        let factor = slope / whole;
        // Derivatives by `turning`, and by `pressing` through each of its scalar products.
        let by_turning = factor * pressing * length;
        let by_pressing = -(factor * rising);
        let along_edge =
            factor * pressing * turning / length + (by_pressing + by_pressing) * start_force;
        let (by_edge_start, by_edge_force, by_start_force) = (
            -(by_pressing * edge_force),
            -(by_pressing * edge_start),
            by_pressing * square,
        );
        let sum = |a: S, u, b: S, v, c: S, w| add(add(scale(a, u), scale(b, v)), scale(c, w));
        Self {
            edge: add(
                scale(along_edge, edge),
                sum(
                    by_turning,
                    by_edge,
                    by_edge_start,
                    start,
                    by_edge_force,
                    force,
                ),
            ),
            start: sum(
                by_turning,
                cross(force, edge),
                by_edge_start,
                edge,
                by_start_force,
                force,
            ),
            force: sum(
                by_turning,
                cross(edge, start),
                by_edge_force,
                edge,
                by_start_force,
                start,
            ),
            moment: scale(-by_turning, edge),
        }
    }
}
