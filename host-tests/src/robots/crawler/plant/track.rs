//! Track of the crawler on the ground: cells along its ground run press on the ground and shear it.
//!
//! Each cell stores how far the ground under it has been sheared since the belt touched it. The
//! belt carries that deformation along. In steady motion it therefore grows in proportion to the
//! distance from the point where the ground meets the track, which is the paper's eq. 7. At rest it
//! stays, so that the robot can stand on a slope. The stress acts against the deformation, along
//! the track and across it. The deformation ends where the stress is largest: ground that has
//! yielded slides along, and still bears.

use super::body::Body;
use super::ground::Ground;
use super::parameters::CrawlerParameters;
use rapier3d_f64::math::Vector;
use tautrack::link::Shaft;

/// Number of cells of one ground run. The two end cells are half as long and press at the ends of
/// the run, because the robot tips over there.
pub const CELLS: usize = 17;
/// Time constant of the force on a sprocket, s. It models the belt's elasticity.
const BELT_LAG: f64 = 0.010;

/// Track of the crawler.
#[derive(Clone, Copy, Debug)]
pub struct Track {
    /// Distance of the track's centre line from the robot's, positive to the left, m.
    left: f64,
    /// Speed of the belt around its pulleys, m/s; forward positive.
    pub speed: f64,
    /// Force of the ground along the belt, forward positive, low-passed, N.
    pub traction: f64,
    driven: bool,
    /// Deformation of the ground under each cell by belt and robot, forward and left, m; rear cell
    /// first.
    pub shear: [[f64; 2]; CELLS],
    /// Whether each cell presses on the ground.
    pub loaded: [bool; CELLS],
    /// Force of the ground on each cell, in world axes, N.
    pub forces: [Vector; CELLS],
}

/// Action of the ground on the robot through a track: the force, its moment about the centre of
/// gravity, and its component along the belt.
#[derive(Clone, Copy, Debug, Default)]
pub struct Action {
    pub force: Vector,
    pub moment: Vector,
    pub traction: f64,
}

impl Track {
    /// Creates a track at rest.
    pub fn new(left: f64) -> Self {
        Self {
            left,
            speed: 0.0,
            traction: 0.0,
            driven: false,
            shear: [[0.0; 2]; CELLS],
            loaded: [false; CELLS],
            forces: [Vector::ZERO; CELLS],
        }
    }

    /// Sets the belt's speed from the motion of the sprocket's shaft. If the node is dead, the belt
    /// moves freely against the friction of the gear.
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

    /// Filters the mean force of the ground along the belt in a step (N) into the traction.
    pub fn pull(&mut self, traction: f64, dt: f64) {
        self.traction += (traction - self.traction) * (dt / (BELT_LAG + dt));
    }

    /// Torque with which the ground resists a positive turn of the sprocket, N m; 0 if the node is
    /// dead.
    pub fn shaft_torque(&self, radius: f64) -> f64 {
        if self.driven {
            self.traction * radius
        } else {
            0.0
        }
    }

    /// Point at which cell number `cell` presses on the ground, in body axes, m.
    pub fn cell(&self, cell: usize, length: f64) -> Vector {
        let along = cell as f64 / (CELLS - 1) as f64 - 0.5;
        Vector::new(along * length, self.left, 0.0)
    }

    /// Advances all cells by `dt` (s): computes their pressure and shear, and returns the sum of
    /// their actions.
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
        let peak = p.soil.deformation_of_peak();
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
                self.forces[cell] = Vector::ZERO;
                continue;
            }
            let velocity = body.velocity_at(place);
            let carried = -stiffness * height - damping * velocity.dot(normal);
            let carried = if carried > 0.0 { carried } else { 0.0 };
            let left = normal.cross(forward).normalize_or_zero();
            let ahead = left.cross(normal);

            // The belt carries the deformation of the neighbouring cell, which touched the ground
            // earlier, into this cell. The first cell of the run receives undeformed ground; its
            // middle is a quarter of a cell from the point where the ground meets the track.
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
            // The neighbour of the second cell is that half cell.
            let distance = if entered == 1 { 0.75 } else { distance } * pitch;
            let carry = self.speed.abs() / distance;
            let turning = body.spin.dot(normal);
            let [x, y] = before[cell];
            let rate = [
                velocity.dot(ahead) - self.speed + carry * (brought[0] - x) + turning * y,
                velocity.dot(left) + carry * (brought[1] - y) - turning * x,
            ];
            let shear = [x + rate[0] * dt, y + rate[1] * dt];
            let size = libm::sqrt(shear[0] * shear[0] + shear[1] * shear[1]);
            let kept = if size > peak { peak / size } else { 1.0 };
            let (shear, size) = (shear.map(|part| part * kept), size * kept);
            self.shear[cell] = shear;

            let stress = p.soil.shear_stress(carried / area, size);
            let per_metre = if size > 0.0 {
                stress * area / size
            } else {
                0.0
            };
            let resists = p.shear_damping * share;
            let [along, across] = [0, 1].map(|i| -per_metre * shear[i] - resists * rate[i]);
            let force = normal * carried + ahead * along + left * across;
            self.forces[cell] = force;
            action.force += force;
            action.moment += (place - body.cog).cross(force);
            action.traction += along;
        }
        action
    }
}

#[cfg(test)]
mod tests {
    use super::super::body::MassProperties;
    use super::super::ground::Profile;
    use super::*;
    use rapier3d_f64::math::Rotation;
    use tautrack::constants::GRAVITY_F64;

    #[test]
    fn ground_resists_a_track_that_slides_however_far_and_whichever_way_it_slid_before() {
        const SPEED: f64 = 0.2;
        const DT: f64 = 1e-3;
        let p = CrawlerParameters::nominal();
        let soil = p.soil;
        let ground = Ground::new(&Profile::default());
        let load = 0.5 * p.mass * GRAVITY_F64;
        let origin = Vector::NEG_Z * (2.0 * load / p.bearing[0]);
        let mut body = Body::at_rest(MassProperties::new(&p, None), origin, Rotation::IDENTITY);
        let mut track = Track::new(0.0);
        let area = p.track_width * p.contact_length;
        let strength = soil.cohesion * area + load * libm::tan(soil.friction_angle);
        let damping = 0.5 * p.shear_damping * SPEED;
        for direction in [Vector::Y, Vector::NEG_Y, Vector::X, Vector::Y] {
            body.velocity = direction * SPEED;
            // A cell is sheared anew after twice the deformation that bears most.
            let sheared = (2.0 * soil.deformation_of_peak() / (SPEED * DT)) as usize;
            for step in 0..5_000 {
                let resists = -track.act(&p, &ground, &body, DT).force.dot(direction);
                if step > 3 * sheared {
                    let expected = strength + damping;
                    assert!((resists / expected - 1.0).abs() < 0.01, "{step}: {resists}");
                }
            }
        }
    }
}
