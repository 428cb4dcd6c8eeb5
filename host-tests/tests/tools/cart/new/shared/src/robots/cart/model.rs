//! Computes the rates of the wheels, and the contacts and centre of gravity of the cart.

use super::parameters::CART;
use crate::math::Scalar;
use crate::settings::{Setting, Settings};

/// Rates of the left and the right wheel, rad/s, for a forward speed (m/s) and a yaw rate (rad/s).
///
/// `radius` and `gauge` are in m and above zero.
pub fn wheel_rates<S: Scalar>(radius: S, gauge: S, forward: S, yaw_rate: S) -> [S; 2] {
    let half = yaw_rate * gauge * S::from_f64(0.5);
    [(forward - half) / radius, (forward + half) / radius]
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
    pub fn new(settings: &Settings) -> Self {
        let [behind, _] = CART.cog(0.0);
        let (caster, side) = (CART.caster as f32, 0.5 * settings.si(Setting::TrackGauge));
        Self {
            contacts: [[-caster, 0.0, 0.0], [0.0, -side, 0.0], [0.0, side, 0.0]],
            cog: [-behind as f32, 0.0, settings.si(Setting::CogHeight)],
        }
    }
}
