//! Applies the tension of a belt to the segments that hold its pulleys.

use super::super::parameters::B2p2Parameters;
use super::super::robot::Robot;
use super::aside::Span;
use super::path::{Bend, Pulleys, Straight};
use rapier3d_f64::glamx::DVec2;
use rapier3d_f64::math::{Pose, Vector};
use rapier3d_f64::prelude::*;

/// Corner of the ground under a belt.
#[derive(Clone, Copy, Debug)]
pub struct Pressed {
    /// Place in world axes, m.
    pub place: Vector,
    /// Force of the corner on the belt, N.
    pub force: Vector,
    /// Part of it to the left of the robot, N.
    pub sideways: f64,
    /// Speed at which the belt slides over the corner backward, m/s.
    pub sliding: f64,
}

/// Plane of one belt, and the segments on which the belt pulls.
#[derive(Clone, Copy, Debug)]
pub struct Grip {
    /// Pose of segment 1, in whose axes the plane is.
    pub plane: Pose,
    /// Distance of the plane from the middle of the robot, to the left, m.
    pub lateral: f64,
    /// Segments that hold pulleys 1 to 3.
    segments: [RigidBodyHandle; 3],
}

impl Grip {
    /// Takes the present pose of the robot.
    pub fn new(world: &PhysicsWorld, robot: &Robot, lateral: f64) -> Self {
        let [first, _, third] = robot.bodies;
        Self {
            plane: *world.bodies[first].position(),
            lateral,
            segments: [first, first, third],
        }
    }

    /// Returns the pulleys in the plane.
    pub fn pulleys(&self, world: &PhysicsWorld, p: &B2p2Parameters) -> Pulleys {
        let third = world.bodies[self.segments[2]].position().translation;
        let third = self.plane.inverse_transform_point(third);
        Pulleys {
            axles: [
                DVec2::ZERO,
                DVec2::new(p.l1, 0.0),
                DVec2::new(third.x, third.z),
            ],
            radius: p.pulley_radius,
        }
    }

    /// Returns a place of the plane in world axes, m.
    pub fn place(&self, place: DVec2) -> Vector {
        let place = Vector::new(place.x, self.lateral, place.y);
        self.plane.transform_point(place)
    }

    /// Returns a direction in the plane in world axes.
    pub fn direction(&self, direction: DVec2) -> Vector {
        self.plane.rotation * Vector::new(direction.x, 0.0, direction.y)
    }

    /// Returns the speed at which straight pieces of the belt become longer, m/s.
    pub fn rate(&self, world: &PhysicsWorld, straights: &[Straight]) -> f64 {
        let speed = |straight: &Straight, end: usize| {
            self.segment(straight.between[end]).map_or(0.0, |handle| {
                let place = self.place(straight.ends[end]);
                let velocity = world.bodies[handle].velocity_at_point(place);
                velocity.dot(self.direction(straight.direction))
            })
        };
        straights
            .iter()
            .map(|straight| speed(straight, 1) - speed(straight, 0))
            .sum()
    }

    /// Pulls both ends of a straight piece towards each other in the next step.
    pub fn pull(&self, world: &mut PhysicsWorld, straight: &Straight, tension: f64) {
        let pull = self.direction(straight.direction) * tension;
        for (end, force) in [pull, -pull].into_iter().enumerate() {
            if let Some(handle) = self.segment(straight.between[end]) {
                let place = self.place(straight.ends[end]);
                world.bodies[handle].add_force_at_point(force, place, false);
            }
        }
    }

    /// Returns the direction across the plane, to the left.
    pub fn left(&self) -> Vector {
        self.plane.rotation * Vector::Y
    }

    /// Returns the speed at which the robot moves to the left over the corner under a span, m/s.
    pub fn sideways(&self, world: &PhysicsWorld, span: &Span) -> f64 {
        let speed = |end: usize| {
            self.segment(span.between[end]).map_or(0.0, |handle| {
                let velocity = world.bodies[handle].velocity_at_point(self.place(span.ends[end]));
                velocity.dot(self.left())
            })
        };
        let [behind, before] = span.parts();
        behind * speed(0) + before * speed(1)
    }

    /// Pushes the pulleys that hold a span to the left with this force in the next step, N.
    pub fn push(&self, world: &mut PhysicsWorld, span: &Span, force: f64) {
        for (end, part) in span.parts().into_iter().enumerate() {
            if let Some(handle) = self.segment(span.between[end]) {
                let place = self.place(span.ends[end]);
                world.bodies[handle].add_force_at_point(self.left() * (force * part), place, false);
            }
        }
    }

    /// Segment that holds a pulley; `None` for a corner.
    fn segment(&self, bend: Bend) -> Option<RigidBodyHandle> {
        match bend {
            Bend::Pulley(pulley) => Some(self.segments[pulley]),
            Bend::Corner(_) => None,
        }
    }
}
