//! The crawler as one rigid body, and its integration in time.

use super::parameters::CrawlerParameters;
use crate::world::inertia::of_point;
use crate::world::load::Load;
use rapier3d_f64::math::{Matrix, Rotation, Vector};
use tautrack::constants::GRAVITY_F64;

/// Mass, centre of gravity and inertia, in body axes (x forward, y left, z up) from the middle
/// between the belts' ground runs.
#[derive(Clone, Copy, Debug)]
pub struct MassProperties {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of gravity, m.
    pub cog: Vector,
    /// Inertia about the centre of gravity, kg m^2.
    pub inertia: Matrix,
}

impl MassProperties {
    /// Mass properties of a box of uniform density with a compact load on it.
    pub fn new(parameters: &CrawlerParameters, payload: Option<Load>) -> Self {
        let p = parameters;
        let [xx, yy, zz] = p.extent.map(|edge| p.mass * edge * edge / 12.0);
        let own = Matrix::from_diagonal(Vector::new(yy + zz, xx + zz, xx + yy));
        let own_cog = Vector::from_array(p.cog);
        let (load, place) = payload.map_or((0.0, Vector::ZERO), |payload| {
            (payload.mass, Vector::from_array(payload.place))
        });
        let mass = p.mass + load;
        let cog = (own_cog * p.mass + place * load) / mass;
        Self {
            mass,
            cog,
            inertia: own + of_point(p.mass, own_cog - cog) + of_point(load, place - cog),
        }
    }
}

/// State of motion in world axes.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    pub properties: MassProperties,
    /// Position of the centre of gravity, m.
    pub cog: Vector,
    /// Velocity of the centre of gravity, m/s.
    pub velocity: Vector,
    pub rotation: Rotation,
    /// Angular velocity, rad/s.
    pub spin: Vector,
}

impl Body {
    /// A body at rest, with the middle between the belts' ground runs at `origin`.
    pub fn at_rest(properties: MassProperties, origin: Vector, rotation: Rotation) -> Self {
        Self {
            properties,
            cog: origin + rotation * properties.cog,
            velocity: Vector::ZERO,
            rotation,
            spin: Vector::ZERO,
        }
    }

    /// Replaces the mass properties while the body moves, without changing its motion.
    pub fn load(&mut self, properties: MassProperties) {
        let shift = self.rotation * (properties.cog - self.properties.cog);
        self.cog += shift;
        self.velocity += self.spin.cross(shift);
        self.properties = properties;
    }

    /// Converts a place on the body from body to world axes.
    pub fn place(&self, local: Vector) -> Vector {
        self.cog + self.rotation * (local - self.properties.cog)
    }

    /// Velocity of the body at `place`, in world axes.
    pub fn velocity_at(&self, place: Vector) -> Vector {
        self.velocity + self.spin.cross(place - self.cog)
    }

    /// Advances by `dt` (s) under a force (N) and its moment about the centre of gravity (N m).
    /// Gravity is added here.
    pub fn step(&mut self, force: Vector, moment: Vector, dt: f64) {
        let properties = &self.properties;
        let turned = Matrix::from_quat(self.rotation);
        let inertia = turned * properties.inertia * turned.transpose();
        let gyroscopic = self.spin.cross(inertia * self.spin);
        self.velocity += (force / properties.mass - Vector::Z * GRAVITY_F64) * dt;
        self.spin += inertia.inverse() * (moment - gyroscopic) * dt;
        self.cog += self.velocity * dt;
        let half = self.spin * (0.5 * dt);
        let change = Rotation::from_xyzw(half.x, half.y, half.z, 0.0) * self.rotation;
        self.rotation = (self.rotation + change).normalize();
    }
}
