//! Describes the attitude of Hylos' platform in the world.

use crate::math::Scalar;
use crate::math::vector::{CoordinateFrame, Vector, zero};

/// Square of the pitch's cosine below which the pitch counts as a quarter turn, and the roll as
/// zero. Both turn about the same line there.
const UPRIGHT: f64 = 1e-6;

/// Attitude by the paper's angles `(phi, psi, theta)`: roll, pitch (nose DOWN positive) and yaw,
/// with `R0P = Rz(theta) Ry(psi) Rx(phi)`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Attitude<S> {
    /// Sines and cosines of roll and pitch.
    pub(super) roll: (S, S),
    pub(super) pitch: (S, S),
    /// Axes of the platform in the world, `R0P`; the origin is not used.
    pub(super) frame: CoordinateFrame<S>,
}

/// Up direction in the platform's axes, from sines and cosines of an inclination as
/// [`crate::estimate::attitude::Attitude`] gives it: roll about the heading (left side up
/// positive), then pitch about the transverse axis (nose UP positive).
pub fn up_from_tilt<S: Scalar>((sp, cp): (S, S), (sr, cr): (S, S)) -> Vector<S> {
    [cr * sp, sr, cr * cp]
}

impl<S: Scalar> Attitude<S> {
    /// Attitude with the angles `(phi, psi, theta)`, rad. Domain: that of [`Scalar::sin_cos`]; NaN
    /// beyond.
    pub fn from_angles(angles: [S; 3]) -> Self {
        let [roll, pitch, yaw] = angles.map(Scalar::sin_cos);
        Self::from_directions(roll, pitch, yaw)
    }

    /// Attitude of a platform in whose axes `up` (a unit vector) is up. The world's x axis is the
    /// platform's heading: level, and perpendicular to the platform's transverse axis, as in
    /// [`crate::estimate::attitude`].
    ///
    /// If the nose points straight up or down, the roll is zero. If the platform lies on its side,
    /// there is no heading, and x is the platform's own.
    pub fn from_up(up: Vector<S>) -> Self {
        let [x, y, z] = up;
        let square = y * y + z * z;
        let (roll, cosine) = if square > S::from_f64(UPRIGHT) {
            let cosine = square.sqrt();
            ((y / cosine, z / cosine), cosine)
        } else {
            ((S::ZERO, S::ONE), S::ZERO)
        };
        // Yaw between the nose's projection on level ground and the heading.
        let (across, along) = (-(x * roll.0), roll.1);
        let square = across * across + along * along;
        let yaw = if square > S::from_f64(UPRIGHT) {
            let per_length = S::ONE / square.sqrt();
            (across * per_length, along * per_length)
        } else {
            (S::ZERO, S::ONE)
        };
        Self::from_directions(roll, (-x, cosine), yaw)
    }

    fn from_directions(roll: (S, S), pitch: (S, S), yaw: (S, S)) -> Self {
        let ((sr, cr), (sp, cp), (sy, cy)) = (roll, pitch, yaw);
        Self {
            roll,
            pitch,
            frame: CoordinateFrame {
                axes: [
                    [cy * cp, sy * cp, -sp],
                    [cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr],
                    [cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr],
                ],
                origin: zero(),
            },
        }
    }

    /// Rows of `R0P`, which transforms from the platform's axes to the world's.
    pub fn rotation(&self) -> [Vector<S>; 3] {
        self.frame.rows().map(|[x, y, z, _]| [x, y, z])
    }

    /// Up direction in the platform's axes.
    #[inline]
    pub fn up(&self) -> Vector<S> {
        let ((sr, cr), (sp, cp)) = (self.roll, self.pitch);
        [-sp, cp * sr, cp * cr]
    }

    /// Transforms a direction from the world's axes to the platform's.
    #[inline]
    pub fn into_platform(&self, direction: Vector<S>) -> Vector<S> {
        self.frame.along_axes(direction)
    }

    /// Matrix `T_phi` of eq. 8: from the rates of the three angles to the angular velocity in the
    /// PLATFORM's axes.
    ///
    /// The matrix in the paper's appendix gives it in the world's axes, but eq. 6 and 8 need it in
    /// the platform's. This matrix is `R0P^T` times the paper's.
    pub fn rate_matrix(&self) -> [Vector<S>; 3] {
        let (sr, cr) = self.roll;
        let [ux, uy, uz] = self.up();
        let (o, l) = (S::ZERO, S::ONE);
        [[l, o, ux], [o, cr, uy], [o, -sr, uz]]
    }

    /// Angular velocity in the platform's axes: `T_phi` times the rates of roll, pitch and yaw.
    #[inline]
    pub(super) fn angular_velocity(&self, [roll, pitch, yaw]: [S; 3]) -> Vector<S> {
        let (sr, cr) = self.roll;
        let [ux, uy, uz] = self.up();
        [
            roll + ux * yaw,
            cr * pitch + uy * yaw,
            uz * yaw - sr * pitch,
        ]
    }

    /// First two elements of `T_phi^T moment`: the derivatives by roll and pitch of a quantity
    /// whose derivative by rotation is `moment`.
    #[inline]
    pub(super) fn about_roll_and_pitch(&self, moment: Vector<S>) -> [S; 2] {
        let (sr, cr) = self.roll;
        [moment[0], cr * moment[1] - sr * moment[2]]
    }
}
