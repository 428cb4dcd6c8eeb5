//! Computes the Jacobians of the segments (Paillat et al., eq. 14 to 18): along the axes of R6 for
//! the dynamics, and in R0 for other users.

use super::super::{JOINTS, Joints};
use super::posture::Posture;
use crate::math::Scalar;
use crate::math::vector::{Vector, about_z, add, cross, scale, to_point_on_x, zero};

/// Effect of a unit rate of one joint on a segment: velocity of its centre of mass, m/s, and
/// angular velocity, rad/s.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Column<S> {
    pub linear: Vector<S>,
    pub angular: Vector<S>,
}

/// Columns of joints 4 to 8; those of joints 1 to 3 are the axes y0, x0 and z0 for every segment.
pub(super) type Columns<S> = [Column<S>; 5];

/// Jacobian of a segment in R0, column by column: the velocity of its centre of mass is
/// `v = sum linear[j] q'_j`, its angular velocity `w = sum angular[j] q'_j`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Jacobian<S> {
    /// Velocity for each joint, m/s: eq. 15 (revolute) and 17 (prismatic). In eq. 15 the factor is
    /// the joint's rate `q'_j`, not `q_j` as printed.
    pub linear: [Vector<S>; JOINTS],
    /// Angular velocity for each joint, rad/s: eq. 14 and 16.
    pub angular: [Vector<S>; JOINTS],
}

/// Angular velocities of the frames that carry the joint axes, along R6, rad/s.
pub(super) struct Spin<S> {
    /// Of R4, R5, R6 and R7.
    pub yaw: Vector<S>,
    pub roll: Vector<S>,
    pub segment_1: Vector<S>,
    pub front: Vector<S>,
}

impl<S: Scalar> Posture<'_, S> {
    /// Jacobians of segments 1 to 3 in R0. Columns 7 and 8 of segment 1 and column 8 of segment 2
    /// are zero.
    pub fn jacobians(&self) -> [Jacobian<S>; 3] {
        let (o, l) = (S::ZERO, S::ONE);
        self.columns().map(|columns| {
            let mut jacobian = Jacobian {
                linear: [zero(); JOINTS],
                angular: [zero(); JOINTS],
            };
            jacobian.linear[0] = [o, l, o];
            jacobian.linear[1] = [l, o, o];
            jacobian.linear[2] = [o, o, l];
            for (index, column) in columns.iter().enumerate() {
                jacobian.linear[3 + index] = self.segment_1.direction(column.linear);
                jacobian.angular[3 + index] = self.segment_1.direction(column.angular);
            }
            jacobian
        })
    }

    /// Columns of joints 4 to 8 of each segment, in R6 axes.
    pub(super) fn columns(&self) -> [Columns<S>; 3] {
        let [first, second, third] = self.local_coms();
        let [arm_2, arm_3] = self.arms();
        let still = Column {
            linear: zero(),
            angular: zero(),
        };
        let turning = |axis, arm| Column {
            linear: cross(axis, arm),
            angular: axis,
        };
        let turning_about_z = |arm| Column {
            linear: about_z(arm),
            angular: [S::ZERO, S::ZERO, S::ONE],
        };
        let segment = |com, chassis, screw| {
            [
                turning(self.yaw_axis, com),
                turning(self.roll_axis, com),
                turning_about_z(com),
                chassis,
                screw,
            ]
        };
        let screw = Column {
            linear: self.along,
            angular: zero(),
        };
        [
            segment(first, still, still),
            segment(second, turning_about_z(arm_2), still),
            segment(third, turning_about_z(arm_3), screw),
        ]
    }

    /// Angular velocities of the frames at these joint rates.
    pub(super) fn spin(&self, rates: &Joints<S>) -> Spin<S> {
        let [.., d4, d5, d6, d7, _] = *rates;
        let yaw = scale(d4, self.yaw_axis);
        let roll = add(yaw, scale(d5, self.roll_axis));
        let segment_1 = [roll[0], roll[1], roll[2] + d6];
        Spin {
            yaw,
            roll,
            segment_1,
            front: [roll[0], roll[1], segment_1[2] + d7],
        }
    }

    /// Time derivatives of [`Self::columns`] as seen from R0, along the axes of R6.
    pub(super) fn column_rates(&self, rates: &Joints<S>, spin: &Spin<S>) -> [Columns<S>; 3] {
        let [first, second, third] = self.local_coms();
        let [arm_2, arm_3] = self.arms();
        // The axes of joints 6 and 7 are both z. So both rates have the same form, each with the
        // angular velocity of the frame that carries the axis.
        let z_rate = |carrier: Vector<S>| [carrier[1], -carrier[0], S::ZERO];
        let (roll_rate, pitch_rate) = (cross(spin.yaw, self.roll_axis), z_rate(spin.roll));
        let along_rate = cross(spin.front, self.along);
        let axle_2_rate = to_point_on_x(spin.segment_1, self.parameters.l1);
        let arm_2_rate = cross(spin.front, arm_2);
        let arm_3_rate = add(cross(spin.front, arm_3), scale(rates[7], self.along));

        let still = Column {
            linear: zero(),
            angular: zero(),
        };
        let turning_about_z = |axis_rate, arm, arm_rate| Column {
            linear: add(cross(axis_rate, arm), about_z(arm_rate)),
            angular: axis_rate,
        };
        let segment = |com, com_rate, chassis, screw| {
            [
                Column {
                    linear: cross(self.yaw_axis, com_rate),
                    angular: zero(),
                },
                Column {
                    linear: add(cross(roll_rate, com), cross(self.roll_axis, com_rate)),
                    angular: roll_rate,
                },
                turning_about_z(pitch_rate, com, com_rate),
                chassis,
                screw,
            ]
        };
        let chassis = |arm, arm_rate| turning_about_z(z_rate(spin.segment_1), arm, arm_rate);
        let screw = Column {
            linear: along_rate,
            angular: zero(),
        };
        [
            segment(first, cross(spin.segment_1, first), still, still),
            segment(
                second,
                add(axle_2_rate, arm_2_rate),
                chassis(arm_2, arm_2_rate),
                still,
            ),
            segment(
                third,
                add(axle_2_rate, arm_3_rate),
                chassis(arm_3, arm_3_rate),
                screw,
            ),
        ]
    }
}
