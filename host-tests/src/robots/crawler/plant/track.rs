//! A track on the ground: cells along its run that press on the ground and shear it.
//!
//! Each cell knows how far the ground under it has been sheared since the belt met it. The belt carries that deformation along,
//! so in steady motion it grows in proportion to the distance from where the ground meets the track, which is the paper's eq. 7;
//! at rest it stays, and the robot stands on a slope. Stress acts against the deformation, along the track and across it.

use super::body::Body;
use super::ground::Ground;
use super::parameters::CrawlerParameters;
use rapier3d_f64::math::Vector;
use tautrack::link::Shaft;

/// Cells of one run. Those at its ends are half as long, and press where the run ends: there the robot turns over.
pub const CELLS: usize = 17;
/// Time constant of the force that a sprocket feels, s: the belt's elasticity.
const BELT_LAG: f64 = 0.010;

/// One track.
#[derive(Clone, Copy, Debug)]
pub struct Track {
    /// Distance of its middle line to the left of the robot's, m.
    left: f64,
    /// Speed of the belt around its pulleys, m/s; forward positive.
    pub speed: f64,
    /// Force of the ground along the belt, forward positive, low-passed, N.
    pub traction: f64,
    driven: bool,
    /// Deformation of the ground under each cell by belt and robot, forward and left, m; rear cell first.
    pub shear: [[f64; 2]; CELLS],
    /// Which cells press on the ground.
    pub loaded: [bool; CELLS],
}

/// What the ground does to the robot through a track: a force, its moment about the centre of gravity, and its part along the belt.
#[derive(Clone, Copy, Debug, Default)]
pub struct Action {
    pub force: Vector,
    pub moment: Vector,
    pub traction: f64,
}

impl Track {
    /// A track at rest.
    pub fn new(left: f64) -> Self {
        Self {
            left,
            speed: 0.0,
            traction: 0.0,
            driven: false,
            shear: [[0.0; 2]; CELLS],
            loaded: [false; CELLS],
        }
    }

    /// Takes the shaft's motion: the belt moves with its sprocket, or freely against the friction of a dead gear.
    pub fn drive(&mut self, shaft: Option<&Shaft>, parameters: &CrawlerParameters, dt: f64) {
        let radius = parameters.sprocket_radius;
        self.driven = shaft.is_some();
        self.speed = if let Some(shaft) = shaft {
            f64::from(shaft.velocity) * radius
        } else {
            let mass = parameters.track_inertia / (radius * radius);
            let free = self.speed - self.traction * dt / mass;
            let stopping = parameters.dead_track_friction / radius * dt / mass;
            if free.abs() <= stopping {
                0.0
            } else {
                free - stopping * free.signum()
            }
        };
    }

    /// Takes the mean force of the ground along the belt in a step.
    pub fn pull(&mut self, traction: f64, dt: f64) {
        self.traction += (traction - self.traction) * (dt / (BELT_LAG + dt));
    }

    /// Torque with which the ground resists a positive turn of the sprocket, N m. Zero without a node.
    pub fn shaft_torque(&self, radius: f64) -> f64 {
        if self.driven {
            self.traction * radius
        } else {
            0.0
        }
    }

    /// Where cell `cell` presses on the ground, in body axes.
    pub fn cell(&self, cell: usize, length: f64) -> Vector {
        let along = cell as f64 / (CELLS - 1) as f64 - 0.5;
        Vector::new(along * length, self.left, 0.0)
    }

    /// Lets the cells press and shear for `dt`.
    pub fn act(
        &mut self,
        parameters: &CrawlerParameters,
        ground: &Ground,
        body: &Body,
        dt: f64,
    ) -> Action {
        let p = parameters;
        let pitch = p.contact_length / (CELLS - 1) as f64;
        let forward = body.rotation * Vector::X;
        let before = self.shear;
        let mut action = Action::default();
        for cell in 0..CELLS {
            let at_end = cell == 0 || cell == CELLS - 1;
            let length = if at_end { 0.5 * pitch } else { pitch };
            let share = 0.5 * length / p.contact_length;
            let [stiffness, damping] = p.bearing.map(|value| value * share);
            let area = p.track_width * length;
            let place = body.place(self.cell(cell, p.contact_length));
            let (height, normal) = ground.height(place);
            self.loaded[cell] = height < 0.0;
            if height >= 0.0 {
                self.shear[cell] = [0.0; 2];
                continue;
            }
            let velocity = body.velocity_at(place);
            let carried = -stiffness * height - damping * velocity.dot(normal);
            let carried = if carried > 0.0 { carried } else { 0.0 };
            let left = normal.cross(forward).normalize_or_zero();
            let ahead = left.cross(normal);

            // What the belt brings: from the cell that met the ground before, or into the run's first cell, whose middle is a quarter
            // of a cell from where the ground meets the track, nothing.
            let entered = if self.speed > 0.0 {
                CELLS - 1 - cell
            } else {
                cell
            };
            let (brought, distance) = match entered {
                0 => ([0.0; 2], 0.25),
                _ if self.speed > 0.0 => (before[cell + 1], 1.0),
                _ => (before[cell - 1], 1.0),
            };
            // The second cell's neighbour is that first one.
            let distance = if entered == 1 { 0.75 } else { distance } * pitch;
            let carry = self.speed.abs() / distance;
            let turning = body.spin.dot(normal);
            let [x, y] = before[cell];
            let rate = [
                velocity.dot(ahead) - self.speed + carry * (brought[0] - x) + turning * y,
                velocity.dot(left) + carry * (brought[1] - y) - turning * x,
            ];
            let shear = [x + rate[0] * dt, y + rate[1] * dt];
            self.shear[cell] = shear;

            let size = libm::sqrt(shear[0] * shear[0] + shear[1] * shear[1]);
            let stress = p.soil.shear_stress(carried / area, size);
            let per_metre = if size > 0.0 {
                stress * area / size
            } else {
                0.0
            };
            let resists = p.shear_damping * share;
            let [along, across] = [0, 1].map(|i| -per_metre * shear[i] - resists * rate[i]);
            let force = normal * carried + ahead * along + left * across;
            action.force += force;
            action.moment += (place - body.cog).cross(force);
            action.traction += along;
        }
        action
    }
}
