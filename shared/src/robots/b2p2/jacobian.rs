//! Jacobians of the segments (Paillat et al., eq. 14 to 18), in the axes of R6 for the dynamics and in R0 for everyone.

use super::posture::Posture;
use super::{JOINTS, Joints};
use crate::math::Scalar;
use crate::math::vector::{Vector, add, cross, scale, sub, zero};

/// What one unit of a joint's rate does to a segment: velocity of its centre of mass, m/s, and angular velocity, rad/s.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Column<S> {
    pub linear: Vector<S>,
    pub angular: Vector<S>,
}

/// Columns of joints 4 to 8; those of joints 1 to 3 are the axes y0, x0 and z0 for every segment.
pub(super) type Columns<S> = [Column<S>; 5];

/// Jacobian of a segment in R0, column by column: `v = sum linear[j] q'_j` of its centre of mass, `w = sum angular[j] q'_j`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Jacobian<S> {
    /// m/s for each joint, eq. 15 (revolute) and 17 (prismatic). In eq. 15 the factor is the joint's rate: `q'_j`, not `q_j` as printed.
    pub linear: [Vector<S>; JOINTS],
    /// rad/s for each joint, eq. 14 and 16.
    pub angular: [Vector<S>; JOINTS],
}

/// Angular velocities in R6 axes, rad/s, of what carries each axis.
pub(super) struct Spin<S> {
    /// Of R4, R5, R6 and R7.
    pub yaw: Vector<S>,
    pub roll: Vector<S>,
    pub segment_1: Vector<S>,
    pub front: Vector<S>,
}

impl<S: Scalar> Posture<'_, S> {
    /// Jacobians of segments 1 to 3 in R0. Columns 7 and 8 of segment 1 and column 8 of segment 2 are zero.
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
        let turning = |axis, arm| Column {
            linear: cross(axis, arm),
            angular: axis,
        };
        let still = Column {
            linear: zero(),
            angular: zero(),
        };
        let pitch_axis = self.front.axes[2];
        let body = |com| {
            [
                turning(self.yaw_axis, com),
                turning(self.roll_axis, com),
                turning(pitch_axis, com),
            ]
        };
        let chassis = |com| turning(pitch_axis, sub(com, self.front.origin));
        let [yaw, roll, pitch] = body(first);
        let [yaw_2, roll_2, pitch_2] = body(second);
        let [yaw_3, roll_3, pitch_3] = body(third);
        let screw = Column {
            linear: self.along,
            angular: zero(),
        };
        [
            [yaw, roll, pitch, still, still],
            [yaw_2, roll_2, pitch_2, chassis(second), still],
            [yaw_3, roll_3, pitch_3, chassis(third), screw],
        ]
    }

    /// Angular velocities at these joint rates.
    pub(super) fn spin(&self, rates: &Joints<S>) -> Spin<S> {
        let [.., d4, d5, d6, d7, _] = *rates;
        let pitch_axis = self.front.axes[2];
        let yaw = scale(d4, self.yaw_axis);
        let roll = add(yaw, scale(d5, self.roll_axis));
        let segment_1 = add(roll, scale(d6, pitch_axis));
        Spin {
            yaw,
            roll,
            segment_1,
            front: add(segment_1, scale(d7, pitch_axis)),
        }
    }

    /// Time derivatives of [`Self::columns`] as seen from R0, given along the axes of R6.
    pub(super) fn column_rates(&self, rates: &Joints<S>, spin: &Spin<S>) -> [Columns<S>; 3] {
        let pitch_axis = self.front.axes[2];
        let [first, second, third] = self.local_coms();
        let from_axle_2 = [second, third].map(|com| sub(com, self.front.origin));
        let axis_rates = [
            zero(),
            cross(spin.yaw, self.roll_axis),
            cross(spin.roll, pitch_axis),
            cross(spin.segment_1, pitch_axis),
        ];
        let axes = [self.yaw_axis, self.roll_axis, pitch_axis];
        let axle_2_rate = cross(spin.segment_1, self.front.origin);
        let along_rate = cross(spin.front, self.along);
        let arm_rates = [
            cross(spin.front, from_axle_2[0]),
            add(
                cross(spin.front, from_axle_2[1]),
                scale(rates[7], self.along),
            ),
        ];
        let turning = |axis_rate, axis, arm, arm_rate| Column {
            linear: add(cross(axis_rate, arm), cross(axis, arm_rate)),
            angular: axis_rate,
        };
        let still = Column {
            linear: zero(),
            angular: zero(),
        };
        let body =
            |index: usize, com, com_rate| turning(axis_rates[index], axes[index], com, com_rate);
        let segment = |com: Vector<S>, com_rate: Vector<S>, chassis, screw| {
            [
                body(0, com, com_rate),
                body(1, com, com_rate),
                body(2, com, com_rate),
                chassis,
                screw,
            ]
        };
        let chassis = |index: usize| {
            turning(
                axis_rates[3],
                pitch_axis,
                from_axle_2[index],
                arm_rates[index],
            )
        };
        let screw = Column {
            linear: along_rate,
            angular: zero(),
        };
        [
            segment(first, cross(spin.segment_1, first), still, still),
            segment(second, add(axle_2_rate, arm_rates[0]), chassis(0), still),
            segment(third, add(axle_2_rate, arm_rates[1]), chassis(1), screw),
        ]
    }
}
