//! Converts the torques of the four motors to the generalized forces `T`.

use super::super::{JOINTS, Joints};
use crate::math::Scalar;

/// Torques at the output shafts of the four gears, N m.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MotorTorques<S> {
    /// Sprocket of the left track (motor 1); positive drives forward.
    pub left: S,
    /// Sprocket of the right track (motor 2); positive drives forward.
    pub right: S,
    /// Chassis joint (motor 3); positive lifts the front.
    pub chassis: S,
    /// Screw (motor 4); positive extends.
    pub screw: S,
}

/// A length that must be above zero and finite is not.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct NotPositive {
    /// Name of the length.
    pub name: &'static str,
    /// Value that was given, m.
    pub got: f64,
}

/// Lengths that convert torques to forces.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Actuation<S> {
    per_radius: S,
    half_gauge: S,
    radians_per_metre: S,
}

impl<S: Scalar> Actuation<S> {
    /// Actuation by tracks `gauge` apart on sprockets of `pulley_radius` (belt included), and by a
    /// screw that advances by `lead` per turn; all in m.
    ///
    /// # Errors
    /// The first length that is not above zero and finite.
    pub fn new(pulley_radius: f64, gauge: f64, lead: f64) -> Result<Self, NotPositive> {
        for (name, got) in [
            ("pulley radius", pulley_radius),
            ("gauge", gauge),
            ("screw lead", lead),
        ] {
            if !(got > 0.0 && got.is_finite()) {
                return Err(NotPositive { name, got });
            }
        }
        Ok(Self {
            per_radius: S::from_f64(1.0 / pulley_radius),
            half_gauge: S::from_f64(0.5 * gauge),
            radians_per_metre: S::from_f64(2.0 * core::f64::consts::PI / lead),
        })
    }

    /// Generalized forces `T` at yaw `q4` (rad), N and N m, without slip of the tracks and losses
    /// in the gears.
    ///
    /// The tracks give a traction `F` along the heading and a moment `N` about the vertical:
    /// `T1 = F cos q4`, `T2 = -F sin q4`, `T4 = N`. The paper says that joints 1, 4, 7 and 8 are
    /// motorized. For joint 1 this is true only at `q4 = 0`; elsewhere joint 2 takes its part. As
    /// in the paper, the traction acts at axle 1 along the level heading. The moment that lifts the
    /// nose, `F` times the pulley radius, is part of the ground's action, not of `T`.
    pub fn generalized_forces(&self, yaw: S, torques: &MotorTorques<S>) -> Joints<S> {
        let (sine, cosine) = yaw.sin_cos();
        let traction = (torques.left + torques.right) * self.per_radius;
        let mut forces = [S::ZERO; JOINTS];
        forces[0] = traction * cosine;
        forces[1] = -(traction * sine);
        forces[3] = (torques.right - torques.left) * self.per_radius * self.half_gauge;
        forces[6] = torques.chassis;
        forces[7] = torques.screw * self.radians_per_metre;
        forces
    }
}
