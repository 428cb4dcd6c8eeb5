//! Dimensions and masses of the cart. All are assumed: nobody has built it.

/// Dimensions, m, and masses, kg. Heights are above the ground.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Parameters {
    /// Radius of a wheel.
    pub wheel_radius: f64,
    /// Distance between the wheels.
    pub gauge: f64,
    /// Distance of the caster behind the axle.
    pub caster: f64,
    /// Mass of a wheel.
    pub wheel_mass: f64,
    /// Mass of the chassis.
    pub chassis_mass: f64,
    /// Length, width and height of the chassis.
    pub chassis_size: [f64; 3],
    /// Height of the centre of mass of the chassis.
    pub chassis_height: f64,
    /// Distance of chassis and mast behind the axle.
    pub behind: f64,
    /// Mass of the head of the mast. The mast itself has no mass.
    pub head_mass: f64,
}

/// A cart of the size of a suitcase.
pub const CART: Parameters = Parameters {
    wheel_radius: 0.08,
    gauge: 0.36,
    caster: 0.3,
    wheel_mass: 0.5,
    chassis_mass: 6.0,
    chassis_size: [0.4, 0.3, 0.1],
    chassis_height: 0.12,
    behind: 0.1,
    head_mass: 1.5,
};

impl Parameters {
    /// Mass of the whole cart.
    pub fn mass(&self) -> f64 {
        self.chassis_mass + self.head_mass + 2.0 * self.wheel_mass
    }

    /// Centre of gravity with the mast's head at height `mast` (m): distance behind the axle and
    /// height above the ground, m.
    pub fn cog(&self, mast: f64) -> [f64; 2] {
        let behind = self.behind * (self.chassis_mass + self.head_mass);
        let up = self.chassis_height * self.chassis_mass
            + mast * self.head_mass
            + 2.0 * self.wheel_radius * self.wheel_mass;
        [behind, up].map(|moment| moment / self.mass())
    }
}
