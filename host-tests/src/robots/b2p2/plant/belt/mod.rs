//! The belts of B2P2: loops that stretch little, run around three pulleys, yield to the corners of
//! the ground, and pull on what they touch.
//!
//! `corners`: the corners of the ground in the plane of a belt. `path`: the shortest loop over
//! them. `tension`: the tensions of its sections. This file applies the tensions to the segments.
//! Where a pulley or a guide plate presses the belt on the ground, the physics engine computes the
//! contact.
//!
//! The tension belongs to the length that the belt has at the end of the step, as the present
//! velocities give it. This acts like a damper of `stiffness * DT`, so that a belt never gains
//! energy as long as the stiffness of a section is below `1 / (w DT^2)`, where `w` is the inverse
//! of the mass that the section moves. For B2P2, `w` is at most 4.4 / kg for one belt and twice as
//! much for both.

mod corners;
pub mod path;
pub mod tension;

use super::parameters::B2p2Parameters;
use super::robot::{Robot, lateral};
use crate::world::ground::Ground;
use crate::world::physics::DT;
use corners::Edges;
use path::{Bend, Corner, Path, Pulleys, Straight};
use rapier3d_f64::glamx::DVec2;
use rapier3d_f64::math::Vector;
use rapier3d_f64::prelude::*;
use tension::Material;

/// Slack beyond which a belt comes off its pulleys, m.
pub const MOST_SLACK: f64 = 0.15;

/// One belt after a step.
#[derive(Clone, Debug, Default)]
pub struct Belt {
    material: Material,
    /// Largest tension, N.
    pub tension: f64,
    /// Length that it has beyond its path, m; negative if it is stretched.
    pub slack: f64,
    /// Force with which it turns pulley 1 backward, N.
    pub load: f64,
    /// Corners that it presses on.
    pub pressed: Vec<Pressed>,
    /// Places through which it is drawn, in world axes: the ends of the straight pieces.
    pub course: Vec<Vector>,
}

/// Corner of the ground under a belt.
#[derive(Clone, Copy, Debug)]
pub struct Pressed {
    /// Place in world axes, m.
    pub place: Vector,
    /// Force of the corner on the belt, N.
    pub force: Vector,
    /// Speed at which the belt slides over the corner backward, m/s.
    pub sliding: f64,
}

/// Both belts.
#[derive(Clone, Debug)]
pub struct Belts {
    edges: Edges,
    /// Left and right belt.
    pub sides: [Belt; 2],
    corners: Vec<Corner>,
}

impl Belts {
    /// Creates the belts of a robot on `ground`.
    pub fn new(ground: &Ground) -> Self {
        Self {
            edges: Edges::of(ground),
            sides: <[Belt; 2]>::default(),
            corners: Vec::new(),
        }
    }

    /// Pulls on the segments in the next step. `speeds` are the speeds at which pulley 1 drives the
    /// belts, m/s.
    pub fn pull(
        &mut self,
        world: &mut PhysicsWorld,
        robot: &Robot,
        p: &B2p2Parameters,
        speeds: [f64; 2],
    ) {
        for handle in robot.bodies {
            let body = &mut world.bodies[handle];
            body.reset_forces(false);
            body.reset_torques(false);
        }
        let rear = *world.bodies[robot.bodies[0]].position();
        let third = world.bodies[robot.bodies[2]].position().translation;
        let third = rear.inverse_transform_point(third);
        let pulleys = Pulleys {
            axles: [
                DVec2::ZERO,
                DVec2::new(p.l1, 0.0),
                DVec2::new(third.x, third.z),
            ],
            radius: p.pulley_radius,
        };
        let belt = p.belt();
        for (side, state) in self.sides.iter_mut().enumerate() {
            let y = lateral(p, side);
            self.edges.cut(&rear, y, &mut self.corners);
            let path = Path::around(&pulleys, &self.corners, p.guide_clearance == 0.0);
            let in_world = |place: DVec2| rear.transform_point(Vector::new(place.x, y, place.y));
            let turned = |direction: DVec2| {
                rear.rotation * Vector::new(direction.x, 0.0, direction.y)
            };
            let owner = |bend: Bend| match bend {
                Bend::Pulley(2) => Some(robot.bodies[2]),
                Bend::Pulley(_) => Some(robot.bodies[0]),
                Bend::Corner(_) => None,
            };
            let speed = |world: &PhysicsWorld, straight: &Straight, end: usize| {
                owner(straight.between[end]).map_or(0.0, |handle| {
                    let place = in_world(straight.ends[end]);
                    world.bodies[handle]
                        .velocity_at_point(place)
                        .dot(turned(straight.direction))
                })
            };
            let sections = path.sections();
            let rates: Vec<f64> = sections
                .iter()
                .map(|section| {
                    path.straights[section.straights.clone()]
                        .iter()
                        .map(|straight| speed(world, straight, 1) - speed(world, straight, 0))
                        .sum()
                })
                .collect();
            let (tensions, touches) = state.material.tensions(
                &belt,
                &sections,
                &rates,
                p.pulley_radius,
                speeds[side] * DT,
                p.friction,
            );
            for (section, tension) in sections.iter().zip(&tensions) {
                for straight in &path.straights[section.straights.clone()] {
                    let pull = turned(straight.direction) * *tension;
                    for (end, force) in [pull, -pull].into_iter().enumerate() {
                        if let Some(handle) = owner(straight.between[end]) {
                            let place = in_world(straight.ends[end]);
                            world.bodies[handle].add_force_at_point(force, place, false);
                        }
                    }
                }
            }
            let length: f64 = sections
                .iter()
                .map(|section| section.length(p.pulley_radius))
                .sum();
            state.slack = belt.length - length;
            state.tension = tensions.iter().fold(0.0, |most, next| next.max(most));
            state.load = tensions[0] - tensions[tensions.len() - 1];
            state.pressed.clear();
            for (index, touch) in touches.iter().enumerate() {
                let [before, behind] = [index, index + 1].map(|section| {
                    let straights = &path.straights[sections[section].straights.clone()];
                    (straights, tensions[section])
                });
                let arriving = before.0.last().map_or(DVec2::ZERO, |last| last.direction);
                let leaving = behind.0.first().map_or(DVec2::ZERO, |first| first.direction);
                state.pressed.push(Pressed {
                    place: in_world(touch.corner.place),
                    force: turned(arriving * before.1 - leaving * behind.1),
                    sliding: touch.sliding,
                });
            }
            state.course.clear();
            for straight in &path.straights {
                state.course.extend(straight.ends.map(in_world));
            }
        }
    }
}
