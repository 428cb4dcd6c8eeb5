//! Joint forces and ground reaction by one pass out and one pass back (Newton-Euler), without any matrix.

use super::Joints;
use super::posture::Posture;
use crate::math::Scalar;
use crate::math::vector::{add, cross, dot, scale};
use crate::stability::zmp::Wrench;

/// What a motion takes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Effort<S> {
    /// Generalized forces `T` of the joints, N and N m: those of `D q'' + C q' = Q + T` (Paillat et al., eq. 13).
    pub forces: Joints<S>,
    /// Reaction of the ground about the origin of R0, along its axes: `F = sum m_i (a_i - g)`,
    /// `M_O = sum (r_i x m_i (a_i - g) + I_i w'_i + w_i x I_i w_i)`.
    pub reaction: Wrench<S>,
}

impl<S: Scalar> Posture<'_, S> {
    /// Forces for these rates and accelerations (m/s, rad/s; m/s^2, rad/s^2), with the ground reaction of the same motion.
    ///
    /// Computed along R6 about axle 1, whose acceleration less gravity is the reading of an accelerometer there. Cost: 424 operations.
    pub fn newton_euler(&self, rates: &Joints<S>, accelerations: &Joints<S>) -> Effort<S> {
        let parameters = self.parameters;
        let [.., d7, d8] = *rates;
        let [a1, a2, a3, a4, a5, a6, a7, a8] = *accelerations;
        let (pitch_axis, along) = (self.front.axes[2], self.along);

        let spin = self.spin(rates);
        let mut turn = add(scale(a4, self.yaw_axis), scale(a5, self.roll_axis));
        turn = add(turn, scale(a6, pitch_axis));
        turn = add(turn, cross(spin.yaw, scale(rates[4], self.roll_axis)));
        turn = add(turn, cross(spin.roll, scale(rates[5], pitch_axis)));
        let swing = add(
            add(turn, scale(a7, pitch_axis)),
            cross(spin.segment_1, scale(d7, pitch_axis)),
        );

        // Accelerations less gravity.
        let base = self.segment_1.along_axes([a2, a1, a3 + parameters.gravity]);
        let of_point = |turn, spin, arm| add(cross(turn, arm), cross(spin, cross(spin, arm)));
        let [first, second, third] = &parameters.segments;
        let arms = self.front_coms().map(|arm| self.front.direction(arm));
        let axle_2 = add(base, of_point(turn, spin.segment_1, self.front.origin));
        let sliding = add(scale(a8, along), scale(d8 + d8, cross(spin.front, along)));
        let force_1 = scale(
            first.mass,
            add(base, of_point(turn, spin.segment_1, first.com)),
        );
        let force_2 = scale(
            second.mass,
            add(axle_2, of_point(swing, spin.front, arms[0])),
        );
        let force_3 = scale(
            third.mass,
            add(add(axle_2, sliding), of_point(swing, spin.front, arms[1])),
        );

        // Both segments of the front turn alike: one inertia serves them.
        let moment_1 = add(
            first.inertia.times(turn),
            cross(spin.segment_1, first.inertia.times(spin.segment_1)),
        );
        let inertia = second.inertia.plus(&third.inertia);
        let (spin_7, swing_7) = (
            self.front.along_axes(spin.front),
            self.front.along_axes(swing),
        );
        let moment_front = self.front.direction(add(
            inertia.times(swing_7),
            cross(spin_7, inertia.times(spin_7)),
        ));

        let about_axle_2 = add(
            moment_front,
            add(cross(arms[0], force_2), cross(arms[1], force_3)),
        );
        let force_front = add(force_2, force_3);
        let force = add(force_1, force_front);
        let moment = add(
            add(moment_1, cross(first.com, force_1)),
            add(about_axle_2, cross(self.front.origin, force_front)),
        );

        let force_0 = self.segment_1.direction(force);
        Effort {
            forces: [
                force_0[1],
                force_0[0],
                force_0[2],
                dot(self.yaw_axis, moment),
                dot(self.roll_axis, moment),
                dot(pitch_axis, moment),
                dot(pitch_axis, about_axle_2),
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
