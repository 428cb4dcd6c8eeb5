//! Computes the zero moment point: the point of a plane where the reaction of the ground acts
//! without tipping anything.

use crate::math::Scalar;
use crate::math::vector::{Vector, add, cross, dot, scale, sub};

/// Force, N, and moment about the origin, N m.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Wrench<S> {
    /// Force.
    pub force: Vector<S>,
    /// Moment about the origin of the frame in which both are given.
    pub moment: Vector<S>,
}

/// A plane, such as the ground.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Plane<S> {
    /// A point of the plane, m.
    pub point: Vector<S>,
    /// Normal of the plane, away from the ground, of any length but zero.
    pub normal: Vector<S>,
}

/// Result of [`zero_moment_point`].
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum ZeroMomentPoint<S> {
    /// Point on the plane, m.
    At(Vector<S>),
    /// There is no such point: the ground would have to pull (`n . F <= 0`), or an input is not
    /// finite. The robot is not stable then.
    None,
}

/// Zero moment point of a ground reaction on `plane`: `Z = p + n x M_p / (n . F)`,
/// `M_p = M_O - p x F`.
///
/// The form holds for any number of moving bodies, with `F = sum m_i (a_i - g)` and
/// `M_O = sum (r_i x m_i (a_i - g) + I_i w'_i + w_i x I_i w_i)`. It replaces eq. 22 of Paillat et
/// al. ([`printed`]), which holds only for a level plane and omits terms. Domain: any; see
/// [`ZeroMomentPoint::None`]. Error: a few rounding errors, divided by the sine of the angle
/// between force and plane.
pub fn zero_moment_point<S: Scalar>(reaction: &Wrench<S>, plane: &Plane<S>) -> ZeroMomentPoint<S> {
    let pressure = dot(plane.normal, reaction.force);
    let about_point = sub(reaction.moment, cross(plane.point, reaction.force));
    let turned = cross(plane.normal, about_point);
    match divided(turned, pressure) {
        Some(offset) => ZeroMomentPoint::At(add(plane.point, offset)),
        None => ZeroMomentPoint::None,
    }
}

/// Zero moment point (x, y) on the level plane through the origin as Paillat et al. print it
/// (eq. 22, from eq. 19 to 21): `Z_x = (-d_y + G_z P_x - G_x P_z) / R_z`,
/// `Z_y = (d_x - G_y P_z + G_z P_y + G_z Fi_y) / R_z`, with `P = -m g z`, `Fi = -m G''`,
/// `R_z = m (g + z'')` and `d` the rate of the angular momentum about `cog`.
///
/// Use it for comparison with the paper only. Eq. 21 omits `G_z Fi_x` and `-G_x Fi_z` from the
/// second line and `G_y Fi_z` from the first, and takes the plane as `z = 0`; eq. 22 follows from
/// it. `d` must be the rate about the centre of gravity, not the dynamic moment at O as its name
/// says, because `OG x Fi` is already included.
///
/// Example: the robot accelerates sideways with 1 m/s^2, with axle 1 0.1 m above the plane. Its
/// zero moment point moves by 12.9 mm, but the printed form does not change. On the random motions
/// of `shared/tests/robots/b2p2_zmp.rs` the two differ by up to 0.38 m.
pub fn printed<S: Scalar>(
    reaction: &Wrench<S>,
    mass: S,
    gravity: S,
    cog: Vector<S>,
) -> Option<[S; 2]> {
    let [gx, gy, gz] = cog;
    let [_, force_y, force_z] = reaction.force;
    let [dx, dy, _] = sub(reaction.moment, cross(cog, reaction.force));
    let weight = mass * gravity;
    // P_x = P_y = 0, P_z = -weight, Fi_y = -force_y.
    let [x, y, _] = divided(
        [gx * weight - dy, dx + gy * weight - gz * force_y, S::ZERO],
        force_z,
    )?;
    Some([x, y])
}

/// `vector / divisor` if the divisor is above zero and the quotient finite.
fn divided<S: Scalar>(vector: Vector<S>, divisor: S) -> Option<Vector<S>> {
    if !(divisor > S::ZERO) {
        return None;
    }
    let quotient = scale(S::ONE / divisor, vector);
    let finite = quotient.into_iter().all(Scalar::is_finite);
    finite.then_some(quotient)
}
