//! Computes the terms of the equations of motion `D(q) q'' + C(q, q') q' = Q + T` (Paillat et al.,
//! eq. 13).
//!
//! Lagrange's equation (3) holds with the kinetic energy as `L` and gravity in `Q`. The reason that
//! the paper gives ("rigid segments, so there is no potential energy") is not valid.

use super::super::{JOINTS, JointMatrix, Joints};
use super::posture::Posture;
use crate::math::Scalar;
use crate::math::vector::{Symmetric, Vector, about_z, cross, dot, scale, sub};

impl<S: Scalar> Posture<'_, S> {
    /// Inertia matrix `D` (eq. 7 to 9), kg, kg m and kg m^2: symmetric and positive definite.
    ///
    /// Eq. 7 is `sum m_i Jv^T Jv + Jw^T R I R^T Jw` with `I` about the centre of mass. It is summed
    /// by composite bodies instead of by Jacobians: the front as one body about axle 2, the whole
    /// robot as one about axle 1, both along R6. Cost: 279 operations.
    pub fn inertia_matrix(&self) -> JointMatrix<S> {
        let [first, second, third] = &self.parameters.segments;
        let [_, arm_3] = self.front_coms();
        let [moment, front_moment] = self.moments();

        // The front about axle 2, first along R7, then along R6; x7 is turned by joint 7 and a
        // quarter turn.
        let (sine, cosine) = self.chassis;
        let front = second
            .inertia_about_origin
            .plus(&third.inertia)
            .plus(&Symmetric::point_mass(third.mass, arm_3))
            .turned_about_z(cosine, -sine);

        // The whole about axle 1: the front is `L1` further along x.
        let l1 = self.parameters.l1;
        let [hx, hy, hz] = front_moment;
        let across = l1 * (hx + hx + (second.mass + third.mass) * l1);
        let shift = Symmetric {
            diagonal: [S::ZERO, across, across],
            mixed: [S::ZERO, -(l1 * hz), -(l1 * hy)],
        };
        let whole = first.inertia_about_origin.plus(&front).plus(&shift);

        let linear = self.momenta(moment, front_moment);
        let yaw_momentum = whole.times(self.yaw_axis);
        let roll_momentum = whole.times(self.roll_axis);
        let [yz, zx, _] = front.mixed;
        let chassis_momentum = [zx, yz, front.diagonal[2] + l1 * hx];
        let [x, y, z] = self.along_r6(arm_3);
        let screw_momentum = cross([l1 + x, y, z], linear[4]);

        let mut d = [[S::ZERO; JOINTS]; JOINTS];
        let mut set = |row: usize, column: usize, value: S| {
            d[row][column] = value;
            d[column][row] = value;
        };
        for joint in 0..3 {
            set(joint, joint, self.parameters.mass);
        }
        for (index, momentum) in linear.into_iter().enumerate() {
            let [right, forward, up] = self.segment_1.direction(momentum);
            set(0, 3 + index, forward);
            set(1, 3 + index, right);
            set(2, 3 + index, up);
        }
        set(3, 3, dot(self.yaw_axis, yaw_momentum));
        set(3, 4, dot(self.roll_axis, yaw_momentum));
        set(3, 5, yaw_momentum[2]);
        set(4, 4, dot(self.roll_axis, roll_momentum));
        set(4, 5, roll_momentum[2]);
        set(5, 5, whole.diagonal[2]);
        for (column, momentum) in [(6, chassis_momentum), (7, screw_momentum)] {
            set(3, column, dot(self.yaw_axis, momentum));
            set(4, column, dot(self.roll_axis, momentum));
            set(5, column, momentum[2]);
        }
        set(6, 6, front.diagonal[2]);
        // Across the front, from axle 2. The component y7 of the arm has no effect.
        set(6, 7, -(third.mass * arm_3[0]));
        set(7, 7, third.mass);
        d
    }

    /// Momentum of the robot for unit rates of joints 4 to 8, along R6, from the first moments of
    /// mass of the whole robot about axle 1 and of the front about axle 2, kg m.
    fn momenta(&self, moment: Vector<S>, front_moment: Vector<S>) -> [Vector<S>; 5] {
        [
            cross(self.yaw_axis, moment),
            cross(self.roll_axis, moment),
            about_z(moment),
            about_z(front_moment),
            scale(self.parameters.segments[2].mass, self.along),
        ]
    }

    /// Generalized forces of gravity `Q_j = -sum_i g m_i dz_i / dq_j`, N and N m.
    ///
    /// Eq. 10 is printed without the minus sign. That is right only for `g = -9.81` with z0
    /// pointing up. Cost: 81 operations.
    pub fn gravity_forces(&self) -> Joints<S> {
        let [moment, front_moment] = self.moments();
        // Weight of a unit mass along the axes of R6: a row of R06.
        let [x6, y6, z6] = self.segment_1.axes;
        let weight = scale(-self.parameters.gravity, [x6[2], y6[2], z6[2]]);
        let [yaw, roll, pitch, chassis, screw] = self.momenta(moment, front_moment);
        [
            S::ZERO,
            S::ZERO,
            -(self.parameters.gravity * self.parameters.mass),
            dot(weight, yaw),
            dot(weight, roll),
            dot(weight, pitch),
            dot(weight, chassis),
            dot(weight, screw),
        ]
    }

    /// Coriolis and centrifugal matrix `C` at `rates` (m/s, rad/s). Its elements are
    /// `X_jm = sum_n c_nmj q'_n` with the Christoffel symbols of eq. 12, so that `D' - 2 C` is
    /// skew-symmetric. Columns 1 to 3 are zero. Cost: 1752 operations.
    ///
    /// No derivative of `D` is formed. For a rigid segment the symbols of eq. 12 sum to
    /// `X_jm = Jv_j . m Jv'_m + Jw_j . (I Jw'_m - w x (E Jw_m))`, where `E = tr(I) / 2 - I` is its
    /// second moment of mass. This is because in the general identity for a chain,
    /// `dJw_m/dq_n - dJw_n/dq_m = Jw_n x Jw_m` leaves `(w x I - I w x - (I w) x) / 2` beside
    /// `I Jw'`, and that equals `-w x E`.
    pub fn coriolis_matrix(&self, rates: &Joints<S>) -> JointMatrix<S> {
        let spin = self.spin(rates);
        let (columns, column_rates) = (self.columns(), self.column_rates(rates, &spin));
        let (sine, cosine) = self.chassis;
        let [first, second, third] = &self.parameters.segments;
        let inertias = [
            first.inertia,
            second.inertia.turned_about_z(cosine, -sine),
            third.inertia.turned_about_z(cosine, -sine),
        ];
        let spins = [spin.segment_1, spin.front, spin.front];

        let mut c = [[S::ZERO; JOINTS]; JOINTS];
        for segment in 0..3 {
            let (inertia, mass) = (inertias[segment], self.parameters.segments[segment].mass);
            let second_moment = inertia.complement();
            // Joints 7 and 8 do not move the segments behind them.
            for m in 0..3 + segment {
                let (column, rate) = (columns[segment][m], column_rates[segment][m]);
                let force = scale(mass, rate.linear);
                let moment = sub(
                    inertia.times(rate.angular),
                    cross(spins[segment], second_moment.times(column.angular)),
                );
                let [right, forward, up] = self.segment_1.direction(force);
                c[0][3 + m] += forward;
                c[1][3 + m] += right;
                c[2][3 + m] += up;
                for (j, other) in columns[segment].iter().enumerate().take(3 + segment) {
                    c[3 + j][3 + m] += dot(other.linear, force) + dot(other.angular, moment);
                }
            }
        }
        c
    }

    /// Generalized forces `T = D q'' + C q' - Q` (eq. 13) for these rates and accelerations (m/s,
    /// rad/s; m/s^2, rad/s^2), N and N m.
    ///
    /// Computed by the matrices, in 2368 operations; [`Self::newton_euler`] gives the same in 438.
    pub fn lagrange(&self, rates: &Joints<S>, accelerations: &Joints<S>) -> Joints<S> {
        let (d, c) = (self.inertia_matrix(), self.coriolis_matrix(rates));
        let mut forces = self.gravity_forces().map(|force| -force);
        for (row, force) in forces.iter_mut().enumerate() {
            for column in 0..JOINTS {
                *force += d[row][column] * accelerations[column] + c[row][column] * rates[column];
            }
        }
        forces
    }
}
