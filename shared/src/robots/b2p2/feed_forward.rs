//! Computes the torque of the chassis joint and the force of the screw that move the front part as
//! commanded. As torque feed-forward they act before any position error arises.

use super::masses::Masses;
use super::parameters::LENGTHS;
use super::shape::AXLE_3_FROM_BODY_3;
use crate::estimate::attitude::Attitude;
use crate::math::sin_cos;
use crate::motor::profile::Motion;
use crate::screw::{Extension, Geometry, metres};
use crate::settings::Settings;

/// Load of the two drives that move the front part.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Load {
    /// Torque of the chassis joint, positive lifts the front, N m.
    pub joint: f32,
    /// Force of the screw, positive extends, N.
    pub screw: f32,
}

/// Front part about axle 2, with prepared sums: body 2 turns, body 3 turns and slides.
#[derive(Clone, Copy, Debug)]
pub struct FrontPart {
    gravity: f32,
    /// Mass of body 3, kg, and distance of its centre of mass behind axle 3, m.
    mass: f32,
    behind: f32,
    /// First moments about axle 2, kg m: of body 2 along the front part, and of both bodies across
    /// it.
    along: f32,
    across: f32,
    /// Moment of inertia about axle 2, as if body 3's centre of mass were at axle 2 along the front
    /// part, kg m^2.
    inertia: f32,
    /// `L2`, m.
    l2: f32,
}

impl FrontPart {
    /// Front part with the masses of these settings, in a robot of this geometry.
    pub fn new(geometry: &Geometry, settings: &Settings) -> Self {
        let Masses {
            body_2,
            body_3,
            inertia: [inertia_2, inertia_3],
            ..
        } = Masses::new(settings);
        let ([along, _, up], [forward, _, across]) = (body_2.place, body_3.place);
        Self {
            gravity: LENGTHS.gravity as f32,
            mass: body_3.mass,
            behind: AXLE_3_FROM_BODY_3 - forward,
            along: body_2.mass * along,
            across: body_2.mass * up + body_3.mass * across,
            // Parallel axes. The distance of body 3 along the front part changes and is added
            // later.
            inertia: inertia_2
                + body_2.mass * (along * along + up * up)
                + inertia_3
                + body_3.mass * across * across,
            l2: metres(geometry.l2()),
        }
    }

    /// Load while the joint moves as `chassis`, with the body at rest in `attitude`. `extension` is
    /// that of the screw at this chassis angle, and `curve` its second derivative, m/rad^2.
    ///
    /// These are rows 7 and 8 of `D q'' + C q' - Q` (Paillat et al., eq. 13), with motion of
    /// joints 7 and 8 only.
    /// The coupling through body 3's 0.09 mm across the front part is left out. Ground under the
    /// front and strain in the belt are not known here.
    ///
    /// Domain: any. Worst error 1.4e-4 N m and 7.7e-4 N up to 2 rad/s and 8 rad/s^2
    /// (`shared/tests/robots/b2p2_feed_forward.rs`). Cost on Cortex-M4: about 145
    /// instructions.
    #[inline]
    pub fn load(
        &self,
        extension: Extension,
        curve: f32,
        chassis: &Motion,
        attitude: &Attitude,
    ) -> Load {
        let theta = chassis.position.angle();
        let (reach, slope) = (
            self.l2 + metres(extension.length),
            metres(extension.derivative),
        );
        let (rate, acceleration) = (chassis.velocity, chassis.acceleration);
        let square = rate * rate;
        let sliding = curve * square + slope * acceleration;

        // Distance of body 3's centre of mass from axle 2 along the front part.
        let arm = reach - self.behind;
        let moment = self.mass * arm;
        let (sine, cosine) = sin_cos(theta + attitude.pitch());
        let weight = self.gravity * sin_cos(attitude.roll()).1;
        Load {
            joint: (self.inertia + moment * arm) * acceleration
                + 2.0 * moment * slope * square
                + weight * ((self.along + moment) * cosine - self.across * sine),
            screw: self.mass * (sliding - arm * square + weight * sine),
        }
    }
}
