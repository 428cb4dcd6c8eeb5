//! The belts of B2P2: loops that stretch little, run around three pulleys, yield to the corners of
//! the ground, and pull on what they touch.
//!
//! `corners`: the corners of the ground in the plane of a belt. [`inside`]: those that it does not
//! feel. [`path`]: the shortest loop over them. [`tension`]: the tensions of its sections. `aside`:
//! how corners hold it sideways. `pull`: what it pulls on. `drawn`: the line through which it is
//! drawn.
//! Where a pulley or a guide plate presses the belt on the ground, the physics engine computes the
//! contact.
//!
//! The tension belongs to the length that the belt has at the end of the step, as the present
//! velocities give it, and the material has losses. Both act as dampers. So an explicit step is
//! stable, and a belt gains no energy, as long as `7 w k DT^2` is below 4, where `k` is the
//! stiffness of a section and `w` the inverse of the mass that it moves. For B2P2, `w` is at most
//! 9 / kg for both belts, and the left side is 3.4 even if no gear held the segments.

mod aside;
mod corners;
mod drawn;
pub mod inside;
pub mod path;
mod pull;
pub mod tension;

use super::parameters::B2p2Parameters;
use super::robot::{Robot, lateral};
use crate::world::ground::Ground;
use crate::world::physics::DT;
use aside::{Aside, Span};
use corners::Edges;
use inside::Inside;
use path::{Corner, Path};
use pull::{Grip, Pressed};
use rapier3d_f64::math::Vector;
use rapier3d_f64::prelude::*;
use tension::Material;

/// Slack from which a belt leaves the guides of its pulleys, m (assumed). With the front at -60
/// degrees, a belt that is released completely has 0.1 m.
const MOST_SLACK: f64 = 0.30;
/// Side force under which a slack belt leaves them, N (assumed: more than the robot's weight).
const MOST_SIDE_FORCE: f64 = 100.0;
/// Time constant with which side forces act, s.
const SIDE_LAG: f64 = 0.1;

/// One belt after a step.
#[derive(Clone, Debug, Default)]
pub struct Belt {
    material: Material,
    aside: Aside,
    /// Largest tension, N.
    pub tension: f64,
    /// Length that it has beyond its path, m; negative if it is stretched.
    pub slack: f64,
    /// Force with which it turns pulley 1 backward, N.
    pub load: f64,
    /// Corners that it presses on.
    pub pressed: Vec<Pressed>,
    /// Force of the ground across it, low-passed, N.
    side_force: f64,
    /// Places through which it is drawn, in world axes, m: the ends of its straight pieces.
    pub course: Vec<Vector>,
}

/// Both belts.
#[derive(Clone, Debug)]
pub struct Belts {
    edges: Edges,
    corners: Vec<Corner>,
    inside: [Inside; 2],
    /// Left and right belt.
    pub sides: [Belt; 2],
}

impl Belts {
    /// Creates the belts of a robot on `ground`.
    pub fn new(ground: &Ground) -> Self {
        Self {
            edges: Edges::of(ground),
            corners: Vec::new(),
            inside: <[Inside; 2]>::default(),
            sides: <[Belt; 2]>::default(),
        }
    }

    /// Pulls on the segments in the next step. `speeds` are the speeds at which pulley 1 drives the
    /// belts, m/s; `friction` is that of the ground under each.
    pub fn pull(
        &mut self,
        world: &mut PhysicsWorld,
        robot: &Robot,
        p: &B2p2Parameters,
        speeds: [f64; 2],
        friction: [f64; 2],
    ) {
        for handle in robot.bodies {
            let body = &mut world.bodies[handle];
            body.reset_forces(false);
            body.reset_torques(false);
        }
        for (side, speed) in speeds.into_iter().enumerate() {
            let grip = Grip::new(world, robot, lateral(p, side));
            self.edges.cut(&grip.plane, grip.lateral, &mut self.corners);
            let pulleys = grip.pulleys(world, p);
            let guided = p.guide_clearance == 0.0;
            let path = self.inside[side].path(&pulleys, &self.corners, guided);
            self.sides[side].step(world, &grip, &path, p, [speed * DT, friction[side]]);
        }
    }
}

impl Belt {
    fn step(
        &mut self,
        world: &mut PhysicsWorld,
        grip: &Grip,
        path: &Path,
        p: &B2p2Parameters,
        [fed, friction]: [f64; 2],
    ) {
        let (belt, sections) = (p.belt(), path.sections());
        let rates: Vec<f64> = sections
            .iter()
            .map(|section| grip.rate(world, &path.straights[section.straights.clone()]))
            .collect();
        let (tensions, touches) =
            self.material
                .tensions(&belt, &sections, &rates, p.pulley_radius, fed, friction);
        for (section, tension) in sections.iter().zip(&tensions) {
            for straight in &path.straights[section.straights.clone()] {
                grip.pull(world, straight, *tension);
            }
        }
        let length: f64 = sections
            .iter()
            .map(|section| section.length(p.pulley_radius))
            .sum();
        self.slack = belt.length - length;
        self.tension = tensions.iter().fold(0.0, |most, next| next.max(most));
        self.load = tensions[0] - tensions[tensions.len() - 1];
        self.pressed.clear();
        self.aside.keep(&touches);
        self.aside.rigidity = p.belt_rigidity();
        for (index, touch) in touches.iter().enumerate() {
            let arrives = sections[index].straights.end - 1;
            let leaves = sections[index + 1].straights.start;
            let direction = |straight: usize| path.straights[straight].direction;
            let force =
                direction(arrives) * tensions[index] - direction(leaves) * tensions[index + 1];
            let sideways = Span::over(path, arrives).map_or(0.0, |span| {
                let speed = grip.sideways(world, &span);
                let most = friction * force.length();
                let sideways = self.aside.force(touch, &span, speed, most);
                grip.push(world, &span, sideways);
                sideways
            });
            self.pressed.push(Pressed {
                place: grip.place(touch.corner.place),
                force: grip.direction(force) + grip.left() * sideways,
                sideways,
                sliding: touch.sliding,
            });
        }
        self.course.clear();
        for straight in &path.straights {
            self.course.extend(straight.ends.map(|end| grip.place(end)));
        }
    }

    /// Takes the force of the ground across the belt in this step, N. Returns whether the belt
    /// leaves the guides of its pulleys.
    pub fn comes_off(&mut self, side_force: f64) -> bool {
        self.side_force += (side_force - self.side_force) * (DT / (SIDE_LAG + DT));
        let pushed = self.side_force.abs() > MOST_SIDE_FORCE;
        self.slack > MOST_SLACK || (self.slack > 0.0 && pushed)
    }
}
