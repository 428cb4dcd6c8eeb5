//! Computes the position of every frame at one `q`: the Denavit-Hartenberg chain of Paillat et al.
//! (appendix, table 1), in Khalil's convention
//! `T(j-1, j) = Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r)`.
//!
//! Most of the table is zeros and right angles, so the products of its matrices are written out.
//! Joints 1 to 3 only add, R3 has the axes of R0, joints 4 to 6 turn about one point, and the front
//! (R7, R8) lies in the plane of x6 and y6. Values for the dynamics are kept along the axes of R6,
//! those of segment 1: there the axes of joints 6 and 7 are z, and segment 1 stands still.

use super::super::parameters::Parameters;
use super::super::{JOINTS, Joints};
use crate::math::Scalar;
use crate::math::vector::{CoordinateFrame, Vector, add, dot, scale, sub, zero};

/// Posture of the robot at one `q`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Posture<'a, S> {
    pub(super) parameters: &'a Parameters<S>,
    /// R6 in R0: x forward along segment 1, y up, z to the right; the origin is the middle of
    /// axle 1.
    pub(super) segment_1: CoordinateFrame<S>,
    /// Axes of joints 4 (z4) and 5 (z5) in R6.
    pub(super) yaw_axis: Vector<S>,
    pub(super) roll_axis: Vector<S>,
    /// Sine and cosine of joint 7, between R6 and R7.
    pub(super) chassis: (S, S),
    /// Forward along the front (z8), in R6.
    pub(super) along: Vector<S>,
    /// `L2 + q8`, m.
    pub(super) reach: S,
    /// R4 in R0: its axes x and y.
    level: [Vector<S>; 2],
    /// x5 in R0.
    upright: Vector<S>,
}

impl<'a, S: Scalar> Posture<'a, S> {
    /// Posture at `q` (m, rad). Domain: any; angles beyond the domain of [`Scalar::sin_cos`] and
    /// NaN give NaN.
    #[inline]
    pub fn new(parameters: &'a Parameters<S>, q: &Joints<S>) -> Self {
        let [q1, q2, q3, q4, q5, q6, q7, q8] = *q;
        let directions = [q4.sin_cos(), q5.sin_cos(), q6.sin_cos(), q7.sin_cos()];
        Self::from_directions(parameters, [q1, q2, q3], directions, q8)
    }

    /// Same as [`Self::new`], from sines and cosines of joints 4 to 7, such as those of
    /// [`crate::math::sin_cos`]. Cost: 25 operations in addition to the sines.
    ///
    /// `shared/tests/robots/b2p2_model.rs` counts the operations of all functions here.
    #[inline]
    pub fn from_directions(
        parameters: &'a Parameters<S>,
        [q1, q2, q3]: [S; 3],
        [(s4, c4), (s5, c5), (s6, c6), (s7, c7)]: [(S, S); 4],
        q8: S,
    ) -> Self {
        let zero = S::ZERO;
        let (x4, y4) = ([c4, s4, zero], [-s4, c4, zero]);
        // T45: x5 = s5 x4 + c5 z4, y5 = c5 x4 - s5 z4, z5 = y4.
        let x5 = [s5 * c4, s5 * s4, c5];
        let y5 = [c5 * c4, c5 * s4, -s5];
        // T56, the same with s6, c6.
        let x6 = add(scale(s6, x5), scale(c6, y4));
        let y6 = add(scale(c6, x5), scale(-s6, y4));
        Self {
            parameters,
            segment_1: CoordinateFrame {
                axes: [x6, y6, y5],
                origin: [q2, q1, q3],
            },
            yaw_axis: [c5 * s6, c5 * c6, -s5],
            roll_axis: [c6, -s6, zero],
            chassis: (s7, c7),
            along: [c7, s7, zero],
            reach: parameters.l2 + q8,
            level: [x4, y4],
            upright: x5,
        }
    }

    /// Frames R1 to R8 in R0.
    #[inline]
    pub fn frames(&self) -> [CoordinateFrame<S>; JOINTS] {
        let (o, l) = (S::ZERO, S::ONE);
        let (q2, q1) = (self.segment_1.origin[0], self.segment_1.origin[1]);
        let at = |x, y, z, origin| CoordinateFrame {
            axes: [x, y, z],
            origin,
        };
        let base = self.segment_1.origin;
        let [x4, y4] = self.level;
        let [x6, y6, z6] = self.segment_1.axes;
        let (s7, c7) = self.chassis;
        let x7 = sub(scale(c7, y6), scale(s7, x6));
        let z8 = add(scale(c7, x6), scale(s7, y6));
        let axle_2 = add(base, scale(self.parameters.l1, x6));
        let y7 = z8.map(|value| -value);
        [
            at([o, o, -l], [-l, o, o], [o, l, o], [o, q1, o]),
            at([o, l, o], [o, o, l], [l, o, o], [q2, q1, o]),
            at([l, o, o], [o, l, o], [o, o, l], base),
            at(x4, y4, [o, o, l], base),
            at(self.upright, z6, y4, base),
            self.segment_1,
            at(x7, y7, z6, axle_2),
            at(x7, z6, z8, add(axle_2, scale(self.reach, z8))),
        ]
    }

    /// Point on the line of the front at `distance` from axle 2, in R6.
    #[inline]
    fn on_front(&self, distance: S) -> Vector<S> {
        let [x, y, z] = scale(distance, self.along);
        [self.parameters.l1 + x, y, z]
    }

    /// Transforms a direction from the axes of R7 (x up across the front, y backward along it, z to
    /// the right) to those of R6. T67 has the rows `[-s7 -c7 0]` and `[c7 -s7 0]`.
    pub(super) fn along_r6(&self, [x, y, z]: Vector<S>) -> Vector<S> {
        let (s7, c7) = self.chassis;
        [-(s7 * x + c7 * y), c7 * x - s7 * y, z]
    }

    /// Inverse of [`Self::along_r6`].
    pub(super) fn along_r7(&self, [x, y, z]: Vector<S>) -> Vector<S> {
        let (s7, c7) = self.chassis;
        [c7 * y - s7 * x, -(c7 * x + s7 * y), z]
    }

    /// Centres of mass of segments 2 and 3 from axle 2 (the origin of R7), along R7.
    pub(super) fn front_coms(&self) -> [Vector<S>; 2] {
        let [_, second, third] = &self.parameters.segments;
        let [x, y, z] = third.com;
        [second.com, [x, y - self.reach, z]]
    }

    /// Centres of mass of segments 2 and 3 from axle 2, along R6.
    pub(super) fn arms(&self) -> [Vector<S>; 2] {
        self.front_coms().map(|com| self.along_r6(com))
    }

    /// Centres of mass of the segments from the origin of R6, in its axes.
    pub(super) fn local_coms(&self) -> [Vector<S>; 3] {
        let l1 = self.parameters.l1;
        let [second, third] = self.arms().map(|[x, y, z]| [l1 + x, y, z]);
        [self.parameters.segments[0].com, second, third]
    }

    /// First moments of mass along R6, kg m: of the whole robot about axle 1, and of the front
    /// about axle 2.
    pub(super) fn moments(&self) -> [Vector<S>; 2] {
        let [first, second, third] = &self.parameters.segments;
        let [arm_2, arm_3] = self.arms();
        let front = add(scale(second.mass, arm_2), scale(third.mass, arm_3));
        let mut whole = add(scale(first.mass, first.com), front);
        whole[0] += (second.mass + third.mass) * self.parameters.l1;
        [whole, front]
    }

    /// Centre of gravity from the origin of R6, in its axes.
    fn local_cog(&self) -> Vector<S> {
        let [moment, _] = self.moments();
        scale(S::ONE / self.parameters.mass, moment)
    }

    /// Centres of mass of the segments in R0, m.
    pub fn coms(&self) -> [Vector<S>; 3] {
        self.local_coms().map(|com| self.segment_1.place(com))
    }

    /// Centre of gravity in R0, m: `G = sum m_i T_j(i) [x_i y_i z_i 1]^T / sum m_i` (appendix,
    /// eq. 1).
    #[inline]
    pub fn cog(&self) -> Vector<S> {
        self.segment_1.place(self.local_cog())
    }

    /// Axles 1 to 3 from the origin of R6, in its axes; axle 3 is `axle_3` in front of the origin
    /// of R8.
    fn local_axles(&self) -> [Vector<S>; 3] {
        let third = self.on_front(self.reach + self.parameters.axle_3);
        [zero(), self.on_front(S::ZERO), third]
    }

    /// Middles of axles 1 to 3 in R0, m.
    pub fn axles(&self) -> [Vector<S>; 3] {
        self.local_axles().map(|axle| self.segment_1.place(axle))
    }

    /// Positions of axles 1 to 3 (the points P1, P2 and P3 of the paper's Fig. 8) and of the centre
    /// of gravity along the heading, m from axle 1: their coordinates along z5, which stays level.
    ///
    /// `P2 = L1 cos q6`, `P3 = L1 cos q6 + r cos(q6 + q7)`.
    pub fn along_heading(&self) -> ([S; 3], S) {
        let coordinate = |place| dot(self.roll_axis, place);
        (
            self.local_axles().map(coordinate),
            coordinate(self.local_cog()),
        )
    }
}
