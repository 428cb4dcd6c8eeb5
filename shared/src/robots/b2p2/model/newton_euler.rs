//! Computes joint forces and ground reaction by one pass outward and one pass back (Newton-Euler),
//! without any matrix.

use super::super::Joints;
use super::posture::Posture;
use crate::math::Scalar;
use crate::math::vector::{Vector, add, cross, dot, scale, to_point_on_x};
use crate::stability::zmp::Wrench;

/// Forces that a motion requires.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Effort<S> {
    /// Generalized forces `T` of the joints, N and N m: those of `D q'' + C q' = Q + T` (Paillat et
    /// al., eq. 13).
    pub forces: Joints<S>,
    /// Reaction of the ground about the origin of R0, along its axes: `F = sum m_i (a_i - g)`,
    /// `M_O = sum (r_i x m_i (a_i - g) + I_i w'_i + w_i x I_i w_i)`.
    pub reaction: Wrench<S>,
}

impl<S: Scalar> Posture<'_, S> {
    /// Forces for these rates and accelerations (m/s, rad/s; m/s^2, rad/s^2), with the ground
    /// reaction of the same motion.
    ///
    /// Computed along R6 about axle 1. The acceleration of axle 1 minus gravity is what an
    /// accelerometer there reads. Cost: 438 operations.
    pub fn newton_euler(&self, rates: &Joints<S>, accelerations: &Joints<S>) -> Effort<S> {
        let parameters = self.parameters;
        let [.., d5, d6, d7, d8] = *rates;
        let [a1, a2, a3, a4, a5, a6, a7, a8] = *accelerations;
        let (l1, along) = (parameters.l1, self.along);
        let [first, second, third] = &parameters.segments;

        let spin = self.spin(rates);
        // Angular acceleration of a joint about z that turns at `rate` on a part with the angular
        // velocity `carrier`: `carrier x rate z`, plus the joint's own acceleration.
        let carried =
            |[x, y, _]: Vector<S>, rate, acceleration| [y * rate, -(x * rate), acceleration];
        let yaw_and_roll = add(scale(a4, self.yaw_axis), scale(a5, self.roll_axis));
        let mut turn = add(yaw_and_roll, scale(d5, cross(spin.yaw, self.roll_axis)));
        turn = add(turn, carried(spin.roll, d6, a6));
        let swing = add(turn, carried(spin.segment_1, d7, a7));

        // Accelerations minus gravity.
        let base = self.segment_1.along_axes([a2, a1, a3 + parameters.gravity]);
        let of_point = |turn, spin, arm| add(cross(turn, arm), cross(spin, cross(spin, arm)));
        let centripetal = cross(spin.segment_1, to_point_on_x(spin.segment_1, l1));
        let axle_2 = add(base, add(to_point_on_x(turn, l1), centripetal));
        let sliding = add(scale(a8, along), scale(d8 + d8, cross(spin.front, along)));
        let [arm_2, arm_3] = self.arms();
        let point_1 = add(base, of_point(turn, spin.segment_1, first.com));
        let point_2 = add(axle_2, of_point(swing, spin.front, arm_2));
        let point_3 = add(axle_2, add(sliding, of_point(swing, spin.front, arm_3)));
        let force_1 = scale(first.mass, point_1);
        let force_2 = scale(second.mass, point_2);
        let force_3 = scale(third.mass, point_3);

        // Both segments of the front turn alike, so one inertia is enough.
        let moment_1 = add(
            first.inertia.times(turn),
            cross(spin.segment_1, first.inertia.times(spin.segment_1)),
        );
        let inertia = second.inertia.plus(&third.inertia);
        let (spin_7, swing_7) = (self.along_r7(spin.front), self.along_r7(swing));
        let moment_front = self.along_r6(add(
            inertia.times(swing_7),
            cross(spin_7, inertia.times(spin_7)),
        ));

        let about_axle_2 = add(
            moment_front,
            add(cross(arm_2, force_2), cross(arm_3, force_3)),
        );
        let force_front = add(force_2, force_3);
        let force = add(force_1, force_front);
        // Moment about axle 1 of the force on axle 2: `L1 x` that force.
        let lever = to_point_on_x(force_front, -l1);
        let moment = add(
            add(moment_1, cross(first.com, force_1)),
            add(about_axle_2, lever),
        );

        let force_0 = self.segment_1.direction(force);
        Effort {
            forces: [
                force_0[1],
                force_0[0],
                force_0[2],
                dot(self.yaw_axis, moment),
                dot(self.roll_axis, moment),
                moment[2],
                about_axle_2[2],
                dot(along, force_3),
            ],
            reaction: Wrench {
                force: force_0,
                moment: add(
                    self.segment_1.direction(moment),
                    cross(self.segment_1.origin, force_0),
                ),
            },
        }
    }
}
