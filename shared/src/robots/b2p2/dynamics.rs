//! The equations of motion `D(q) q'' + C(q, q') q' = Q + T` (Paillat et al., eq. 13).
//!
//! Lagrange's equation (3) holds with the kinetic energy as `L` and gravity in `Q`; the paper's reason ("rigid segments, so there is no
//! potential energy") is not one.

use super::posture::Posture;
use super::{JOINTS, JointMatrix, Joints};
use crate::math::Scalar;
use crate::math::vector::{Symmetric, Vector, add, cross, dot, scale, sub};

impl<S: Scalar> Posture<'_, S> {
    /// Inertia matrix `D` (eq. 7 to 9), kg, kg m and kg m^2: symmetric and positive definite.
    ///
    /// Eq. 7, `sum m_i Jv^T Jv + Jw^T R I R^T Jw` with `I` about the centre of mass, is summed by composite bodies instead of by
    /// Jacobians: the front as one body about axle 2, the whole robot as one about axle 1, both along R6. Cost: 248 operations
    /// (eq. 7 as printed: over 2000).
    pub fn inertia_matrix(&self) -> JointMatrix<S> {
        let [first, second, third] = &self.parameters.segments;
        let [arm_2, arm_3] = self.front_coms();
        let front_mass = second.mass + third.mass;
        let moment_2 = scale(second.mass, arm_2);
        let moment_3 = scale(third.mass, arm_3);

        // The front about axle 2, first along R7, then along R6. The turn is the one of R7's x axis.
        let [cosine, sine, _] = self.front.axes[0];
        let front = second
            .inertia_about_origin
            .plus(&third.inertia)
            .plus(&Symmetric::point_mass(third.mass, arm_3))
            .turned_about_z(sine, cosine);
        let front_moment = self.front.direction(add(moment_2, moment_3));

        // The whole about axle 1: the front is `L1` further along x.
        let l1 = self.parameters.l1;
        let [hx, hy, hz] = front_moment;
        let across = l1 * (hx + hx + front_mass * l1);
        let shift = Symmetric {
            diagonal: [S::ZERO, across, across],
            mixed: [S::ZERO, -(l1 * hz), -(l1 * hy)],
        };
        let whole = first.inertia_about_origin.plus(&front).plus(&shift);
        let moment = add(
            add(scale(first.mass, first.com), front_moment),
            [front_mass * l1, S::ZERO, S::ZERO],
        );

        let linear = self.momenta(moment, front_moment);
        let [yz, zx, _] = front.mixed;
        let chassis_momentum = [zx, yz, front.diagonal[2] + l1 * hx];
        let screw_arm = add(self.front.origin, self.front.direction(arm_3));
        let screw_momentum = cross(screw_arm, linear[4]);

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
        let axes = [self.yaw_axis, self.roll_axis, self.front.axes[2]];
        for (row, axis) in axes.into_iter().enumerate() {
            let momentum = whole.times(axis);
            for (column, other) in axes.into_iter().enumerate().skip(row) {
                set(3 + row, 3 + column, dot(momentum, other));
            }
            set(3 + row, 6, dot(axis, chassis_momentum));
            set(3 + row, 7, dot(axis, screw_momentum));
        }
        set(6, 6, front.diagonal[2]);
        // Across the front, from axle 2: y7 of the arm plays no part.
        set(6, 7, -moment_3[0]);
        set(7, 7, third.mass);
        d
    }

    /// Momentum of the robot for unit rates of joints 4 to 8, along R6, from the first moments of mass of the whole about axle 1 and of
    /// the front about axle 2, kg m.
    fn momenta(&self, moment: Vector<S>, front_moment: Vector<S>) -> [Vector<S>; 5] {
        let pitch_axis = self.front.axes[2];
        [
            cross(self.yaw_axis, moment),
            cross(self.roll_axis, moment),
            cross(pitch_axis, moment),
            cross(pitch_axis, front_moment),
            scale(self.parameters.segments[2].mass, self.along),
        ]
    }

    /// Gravity's generalized forces `Q_j = -sum_i g m_i dz_i / dq_j`, N and N m.
    ///
    /// Eq. 10 is printed without the minus sign, which is right only for `g = -9.81` with z0 pointing up.
    pub fn gravity_forces(&self) -> Joints<S> {
        let mut forces = [S::ZERO; JOINTS];
        let gravity = self.parameters.gravity;
        forces[2] = -(gravity * self.parameters.mass);
        // Up (z0) along the axes of R6.
        let up = self.segment_1.along_axes([S::ZERO, S::ZERO, S::ONE]);
        for (segment, columns) in self.parameters.segments.iter().zip(self.columns()) {
            let weight = gravity * segment.mass;
            for (index, column) in columns.iter().enumerate() {
                forces[3 + index] += -(weight * dot(up, column.linear));
            }
        }
        forces
    }

    /// Coriolis and centrifugal matrix `C` at `rates` (m/s, rad/s), its elements `X_jm = sum_n c_nmj q'_n` with the Christoffel symbols of
    /// eq. 12, so that `D' - 2 C` is skew.
    ///
    /// No derivative of `D` is formed. For a rigid segment the symbols of eq. 12 sum to
    /// `X_jm = Jv_j . m Jv'_m + Jw_j . (I Jw'_m - w x (E Jw_m))`, `E = tr(I) / 2 - I` being its second moment of mass: in the general
    /// identity for a chain, `dJw_m/dq_n - dJw_n/dq_m = Jw_n x Jw_m` leaves `(w x I - I w x - (I w) x) / 2` beside `I Jw'`, and that is
    /// `-w x E`. Columns 1 to 3 are zero.
    pub fn coriolis_matrix(&self, rates: &Joints<S>) -> JointMatrix<S> {
        let spin = self.spin(rates);
        let (columns, column_rates) = (self.columns(), self.column_rates(rates, &spin));
        let [cosine, sine, _] = self.front.axes[0];
        let [first, second, third] = &self.parameters.segments;
        let inertias = [
            first.inertia,
            second.inertia.turned_about_z(sine, cosine),
            third.inertia.turned_about_z(sine, cosine),
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

    /// Generalized forces `T = D q'' + C q' - Q` (eq. 13) for these rates and accelerations (m/s, rad/s; m/s^2, rad/s^2), N and N m.
    ///
    /// By the matrices; [`Self::newton_euler`] gives the same far sooner.
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
