//! Computes where the wheels are and touch the ground, and the velocity model of eq. 6 to 12: the
//! locomotion matrix `L` and the Jacobian `J`.
//!
//! Everything is in the platform's axes: x forward, y left, z up, the origin in the middle of the
//! hips. The contact frame of a wheel is `t` (the direction in which it rolls), `l` (to its left)
//! and `n` (the normal of the ground). `L` and `J` are mostly zeros, and the sorting and projection
//! matrices of the appendix only select rows and columns, so no code multiplies them. A row of `L`
//! in the direction `d` is `[R0P d, T_phi^T (p x d)]`; a row of `J` is `d` times the two columns of
//! the leg.

use super::attitude::Attitude;
use super::parameters::Parameters;
use super::{LEGS, Legs};
use crate::math::Scalar;
use crate::math::vector::{Vector, add, cross, dot, scale, sub};

/// Sine of the angle between axle and ground normal below which a wheel lies on its side. Below it,
/// the wheel's contact frame shrinks.
const ON_ITS_SIDE: f64 = 1e-3;

/// Wheel on its leg.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Wheel<S> {
    /// Centre, m.
    pub hub: Vector<S>,
    /// Lowest point of the rim, seen along the ground's normal, m.
    pub contact: Vector<S>,
    /// Direction in which the wheel rolls; with `lateral` and `normal` the contact frame.
    pub tangent: Vector<S>,
    /// Direction to the wheel's left.
    pub lateral: Vector<S>,
    /// Normal of the ground, away from it.
    pub normal: Vector<S>,
    /// Radius over the sine of the angle between axle and normal, m.
    pub(super) stretch: S,
    /// Derivatives of the centre by hip and knee: x and z, because the leg moves in a plane.
    pub(super) columns: [[S; 2]; 2],
}

impl<S: Scalar> Wheel<S> {
    /// Speed of the wheel in the direction `direction` per unit rate of each leg joint.
    #[inline]
    pub(super) fn along(&self, direction: Vector<S>) -> [S; 2] {
        self.columns
            .map(|[x, z]| direction[0] * x + direction[2] * z)
    }

    /// Velocity that the contact point would have if the wheel did not turn: `v_x + v_p` of eq. 10.
    /// `twist` is the velocity and the angular velocity of the platform, `rates` are those of the
    /// leg (eq. 9).
    #[inline]
    pub(super) fn velocity(&self, twist: [Vector<S>; 2], [hip, knee]: [S; 2]) -> Vector<S> {
        let [velocity, turning] = twist;
        let [x, y, z] = add(velocity, cross(turning, self.contact));
        let [[hip_x, hip_z], [knee_x, knee_z]] = self.columns;
        [
            x + hip * hip_x + knee * knee_x,
            y,
            z + hip * hip_z + knee * knee_z,
        ]
    }
}

/// Centre of wheel `leg` (0 to 3), and the columns of its leg's Jacobian (eq. 7).
///
/// Thigh and shank turn in a plane: `q1` forward (backward at the rear) and down from level, `q2`
/// from the thigh. The carrier of the wheel stays parallel to the platform.
pub(super) fn leg_kinematics<S: Scalar>(
    parameters: &Parameters<S>,
    leg: usize,
    [hip, knee]: [S; 2],
) -> (Vector<S>, [[S; 2]; 2]) {
    let p = parameters;
    let (s1, c1) = hip.sin_cos();
    let (sk, ck) = knee.sin_cos();
    let (s2, c2) = (s1 * ck + c1 * sk, c1 * ck - s1 * sk);
    let [thigh, shank] = p.leg;
    let knee_column = [-(shank * s2), -(shank * c2)];
    let hip_column = [knee_column[0] - thigh * s1, knee_column[1] - thigh * c1];
    let (forward, down) = (p.hip_x - hip_column[1], -hip_column[0]);
    let left = if leg.is_multiple_of(2) {
        p.half_track
    } else {
        -p.half_track
    };
    if leg < 2 {
        ([forward, left, -down], [hip_column, knee_column])
    } else {
        let mirrored = [hip_column, knee_column].map(|[x, z]| [-x, z]);
        ([-forward, left, -down], mirrored)
    }
}

/// Posture of the robot at one moment.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Posture<'a, S> {
    pub(super) parameters: &'a Parameters<S>,
    pub(super) attitude: Attitude<S>,
    pub(super) wheels: [Wheel<S>; LEGS],
    pub(super) cog: Vector<S>,
}

impl<'a, S: Scalar> Posture<'a, S> {
    /// Posture with these leg and steering angles, rad, on ground with these unit normals in the
    /// platform's axes.
    ///
    /// Domain: any; NaN and angles beyond the domain of [`Scalar::sin_cos`] give NaN. A wheel that
    /// lies on its side has no contact: its contact frame, and what depends on it, shrink to zero.
    pub fn new(
        parameters: &'a Parameters<S>,
        legs: &Legs<S>,
        steering: &[S; LEGS],
        attitude: Attitude<S>,
        normals: &[Vector<S>; LEGS],
    ) -> Self {
        let least = S::from_f64(ON_ITS_SIDE);
        let wheels = core::array::from_fn(|leg| {
            let (hub, columns) = leg_kinematics(parameters, leg, legs[leg]);
            let (sine, cosine) = steering[leg].sin_cos();
            let (axle, normal) = ([-sine, cosine, S::ZERO], normals[leg]);
            // Perpendicular to axle and normal. Its length is that of the normal's component across
            // the axle.
            let across = cross(axle, normal);
            let length = dot(across, across).sqrt();
            let per_length = S::ONE / if length < least { least } else { length };
            let tangent = scale(per_length, across);
            let stretch = parameters.wheel_radius * per_length;
            let outward = sub(normal, scale(dot(normal, axle), axle));
            Wheel {
                hub,
                contact: sub(hub, scale(stretch, outward)),
                tangent,
                lateral: cross(normal, tangent),
                normal,
                stretch,
                columns,
            }
        });
        Self {
            parameters,
            attitude,
            cog: centre_of_gravity(parameters, &wheels.map(|wheel: Wheel<S>| wheel.hub)),
            wheels,
        }
    }

    /// The wheels: front left, front right, rear left, rear right.
    pub fn wheels(&self) -> &[Wheel<S>; LEGS] {
        &self.wheels
    }

    /// Centre of gravity, m.
    pub fn cog(&self) -> Vector<S> {
        self.cog
    }

    /// Attitude of the platform.
    pub fn attitude(&self) -> &Attitude<S> {
        &self.attitude
    }

    /// Locomotion matrix `L` (eq. 12): rows `t`, `l`, `n` of each wheel; columns x, y, z, roll,
    /// pitch, yaw. For comparison only; the control never forms it.
    pub fn locomotion(&self) -> [[S; 6]; 3 * LEGS] {
        core::array::from_fn(|row| {
            let wheel = &self.wheels[row / 3];
            let direction = [wheel.tangent, wheel.lateral, wheel.normal][row % 3];
            let [x, y, z] = self.attitude.frame.direction(direction);
            let moment = cross(wheel.contact, direction);
            let [roll, pitch] = self.attitude.about_roll_and_pitch(moment);
            [x, y, z, roll, pitch, dot(self.attitude.up(), moment)]
        })
    }

    /// Jacobian `J` (eq. 12): rows as in [`Self::locomotion`]; columns hip, knee, steering and
    /// rolling of each wheel. For comparison only.
    pub fn jacobian(&self) -> [[S; 4 * LEGS]; 3 * LEGS] {
        core::array::from_fn(|row| {
            let (leg, axis) = (row / 3, row % 3);
            let wheel = &self.wheels[leg];
            let [hip, knee] = wheel.along([wheel.tangent, wheel.lateral, wheel.normal][axis]);
            let rolling = if axis == 0 {
                -self.parameters.wheel_radius
            } else {
                S::ZERO
            };
            let block = [hip, knee, S::ZERO, rolling];
            core::array::from_fn(|column| {
                if column / 4 == leg {
                    block[column % 4]
                } else {
                    S::ZERO
                }
            })
        })
    }
}

/// Centre of gravity with the wheels' centres at these places, m.
fn centre_of_gravity<S: Scalar>(
    parameters: &Parameters<S>,
    [a, b, c, d]: &[Vector<S>; LEGS],
) -> Vector<S> {
    let hubs = add(add(*a, *b), add(*c, *d));
    add(
        parameters.platform_part,
        scale(parameters.wheel_share, hubs),
    )
}
