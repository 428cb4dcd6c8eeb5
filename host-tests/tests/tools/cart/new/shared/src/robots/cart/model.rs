//! Computes the rates of the wheels, and the contacts and centre of gravity of the cart.

use crate::math::Scalar;
use crate::settings::{Setting, Settings};

/// Rates of the left and the right wheel, rad/s, for a forward speed (m/s) and a yaw rate (rad/s).
///
/// `radius` and `gauge` are in m and above zero.
pub fn wheel_rates<S: Scalar>(radius: S, gauge: S, forward: S, yaw_rate: S) -> [S; 2] {
    let half = yaw_rate * gauge * S::from_f64(0.5);
    [(forward - half) / radius, (forward + half) / radius]
}

/// Error: the centre of gravity is not between axle and caster.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Unsupported {
    /// Distance of the centre of gravity behind the axle, m.
    pub behind: f32,
    /// Distance of the caster behind the axle, m.
    pub caster: f32,
}

/// Contacts of the cart with the ground, and its centre of gravity.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Shape {
    /// Caster, right wheel, left wheel: counter-clockwise from above.
    pub contacts: [[f32; 3]; 3],
    /// Centre of gravity.
    pub cog: [f32; 3],
}

impl Shape {
    /// Computes the shape from the settings.
    ///
    /// # Errors
    /// The cart would fall over at rest.
    pub fn new(settings: &Settings) -> Result<Self, Unsupported> {
        let (caster, behind) = (
            settings.si(Setting::CasterDistance),
            settings.si(Setting::CogBehind),
        );
        if !(behind > 0.0 && behind < caster) {
            return Err(Unsupported { behind, caster });
        }
        let side = 0.5 * settings.si(Setting::TrackGauge);
        Ok(Self {
            contacts: [[-caster, 0.0, 0.0], [0.0, -side, 0.0], [0.0, side, 0.0]],
            cog: [-behind, 0.0, settings.si(Setting::CogHeight)],
        })
    }
}
