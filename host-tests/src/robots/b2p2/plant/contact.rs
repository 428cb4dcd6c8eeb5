//! Contact of the belts with the ground: applies the surface speed of the belts and reads the
//! forces of the ground.

use super::belt::Belts;
use super::robot::MARKS;
use crate::world::physics::DT;
use rapier3d_f64::geometry::NEW_CONTACT_BIT;
use rapier3d_f64::math::Vector;
use rapier3d_f64::prelude::*;

/// Number of steps for which a contact that carried force counts as support. Single contacts
/// flicker from step to step.
pub const WINDOW: u64 = 50;
/// Minimum force of a contact that counts as support, N.
const LEAST_SUPPORT: f64 = 0.1;
/// Size of a cell, m. Contacts within one cell count as one.
const CELL: f64 = 0.01;
/// Sine of the angle between a face's normal and the pulleys' axis below which the face is a flank
/// of the belt. Flanks do not run.
const FLANK: f64 = 0.3;

/// Returns the direction in which the surface of a belt running forward moves where its outward
/// normal is `outward`; `None` on the belt's flank.
fn running_direction(left: Vector, outward: Vector) -> Option<Vector> {
    let direction = left.cross(outward);
    let length = direction.length();
    (length > FLANK).then(|| direction / length)
}

/// Returns the side (0 left, 1 right) of the belt in a pair of colliders, and whether the belt is
/// the first collider.
fn belt_of(
    colliders: &ColliderSet,
    first: ColliderHandle,
    second: ColliderHandle,
) -> Option<(usize, bool)> {
    let side = |handle: ColliderHandle| {
        MARKS[1..].iter().position(|mark| {
            colliders
                .get(handle)
                .is_some_and(|collider| collider.user_data == *mark)
        })
    };
    side(first)
        .map(|side| (side, true))
        .or_else(|| side(second).map(|side| (side, false)))
}

/// Physics hook that makes the surfaces of the belts run.
pub struct RunningBelts {
    /// Speed of the surface of the left and the right belt, m/s.
    pub speed: [f64; 2],
    /// Direction of the pulleys' axes, to the left.
    pub left: Vector,
}

impl PhysicsHooks for RunningBelts {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext) {
        let Some((side, first)) = belt_of(context.colliders, context.collider1, context.collider2)
        else {
            return;
        };
        let Some(manifold) = context.rigid_mut() else {
            return;
        };
        let sign = if first { 1.0 } else { -1.0 };
        let Some(direction) = running_direction(self.left, *manifold.normal * sign) else {
            return;
        };
        for contact in manifold.solver_contacts.iter_mut() {
            contact.tangent_velocity = direction * (self.speed[side] * sign);
        }
    }
}

/// Forces of the ground on the belts in one step.
#[derive(Clone, Debug, Default)]
pub struct GroundForces {
    /// Force of the ground along the belts, forward positive, left and right, N.
    pub traction: [f64; 2],
    /// Sum of the normal forces' upward parts, N.
    pub lift: f64,
    /// Force of the ground across the belts, to the left, N.
    pub side: [f64; 2],
    /// Sliding speed of the belts' surface on the ground, left and right, m/s: positive if a belt
    /// spins, negative if it skids. Mean over the contacts, weighted by force.
    pub slip: [f64; 2],
    /// Sum of the normal forces, by which the mean of the sliding speed is weighted, N.
    weight: [f64; 2],
}

impl GroundForces {
    fn add_slip(&mut self, side: usize, sliding: f64, force: f64) {
        let weight = self.weight[side] + force;
        if weight > 0.0 {
            self.slip[side] += (sliding - self.slip[side]) * force / weight;
        }
        self.weight[side] = weight;
    }
}

/// Support points: places that carried force within the last [`WINDOW`] steps.
#[derive(Clone, Debug, Default)]
pub struct Support {
    entries: Vec<Entry>,
}

#[derive(Clone, Debug)]
struct Entry {
    cell: [i64; 3],
    point: Vector,
    until: u64,
    /// Force of the ground in the last step in which there was one, N.
    force: Vector,
}

impl Support {
    /// Places and forces of the step number `step`, N.
    pub fn forces(&self, step: u64) -> impl Iterator<Item = (Vector, Vector)> + '_ {
        let entries = self.entries.iter();
        let now = entries.filter(move |entry| entry.until == step + WINDOW);
        now.map(|entry| (entry.point, entry.force))
    }

    /// The support points.
    pub fn points(&self) -> impl Iterator<Item = Vector> + '_ {
        self.entries.iter().map(|entry| entry.point)
    }

    fn add(&mut self, point: Vector, until: u64, force: Vector) {
        let cell = point
            .to_array()
            .map(|coordinate| libm::round(coordinate / CELL) as i64);
        match self.entries.iter_mut().find(|entry| entry.cell == cell) {
            Some(entry) => {
                let before = if entry.until == until {
                    entry.force
                } else {
                    Vector::ZERO
                };
                (entry.point, entry.until, entry.force) = (point, until, before + force);
            }
            None => self.entries.push(Entry {
                cell,
                point,
                until,
                force,
            }),
        }
    }
}

/// Returns the friction impulse of a whole step on the first collider, N s, in world axes.
///
/// The engine gives the impulse of the whole step in its own tangent basis, and that of the last
/// substep both in this basis and in world axes. The rotation from the last substep's impulse to
/// the whole one is the same in both. `normal` is the third axis of the basis.
fn friction_impulse(data: &ContactData, normal: Vector) -> Vector {
    let (whole, last) = (data.tangent_impulse, data.warmstart_tangent_impulse);
    let square = last.x * last.x + last.y * last.y;
    if square == 0.0 {
        return Vector::ZERO;
    }
    let along = (last.x * whole.x + last.y * whole.y) / square;
    let across = (last.x * whole.y - last.y * whole.x) / square;
    data.warmstart_tangent_world * along + normal.cross(data.warmstart_tangent_world) * across
}

/// Adds the forces of the corners that press on the belts between the pulleys.
pub fn add_corners(forces: &mut GroundForces, belts: &Belts, step: u64, support: &mut Support) {
    for (side, belt) in belts.sides.iter().enumerate() {
        forces.traction[side] += belt.load;
        for pressed in &belt.pressed {
            let force = pressed.force.length();
            if force > LEAST_SUPPORT {
                support.add(pressed.place, step + WINDOW, pressed.force);
            }
            forces.lift += pressed.force.z;
            forces.side[side] += pressed.sideways;
            forces.add_slip(side, pressed.sliding, force);
        }
    }
}

/// Reads the ground forces from the contacts after step number `step`, and updates the support
/// points.
pub fn read(
    world: &PhysicsWorld,
    belts: &RunningBelts,
    step: u64,
    support: &mut Support,
) -> GroundForces {
    let mut forces = GroundForces::default();
    for pair in world.contact_pairs() {
        let Some((side, first)) = belt_of(&world.colliders, pair.collider1, pair.collider2) else {
            continue;
        };
        let sign = if first { 1.0 } else { -1.0 };
        let belt = if first {
            pair.collider1
        } else {
            pair.collider2
        };
        let body = world.colliders.get(belt).and_then(Collider::parent);
        let Some(body) = body.and_then(|handle| world.bodies.get(handle)) else {
            continue;
        };
        let Some(pose) = world.colliders.get(belt).map(Collider::position) else {
            continue;
        };
        for manifold in pair.solver_manifolds() {
            let outward = manifold.data.normal * sign;
            let direction = running_direction(belts.left, outward);
            for contact in &manifold.data.solver_contacts {
                let point = &manifold.points[(contact.contact_id[0] & !NEW_CONTACT_BIT) as usize];
                let force = point.data.impulse / DT;
                let local = if first {
                    point.local_p1
                } else {
                    point.local_p2
                };
                let place = pose.transform_point(local);
                let friction = friction_impulse(&point.data, -manifold.data.normal) * (sign / DT);
                if force > LEAST_SUPPORT {
                    support.add(place, step + WINDOW, friction - outward * force);
                }
                forces.lift -= force * outward.z;
                forces.side[side] -= force * outward.dot(belts.left);
                let Some(direction) = direction else { continue };
                forces.lift += friction.z;
                forces.side[side] += friction.dot(belts.left);
                // Where it touches the ground, a belt running forward moves backward.
                forces.traction[side] -= friction.dot(direction);
                let sliding = body.velocity_at_point(place).dot(direction) + belts.speed[side];
                forces.add_slip(side, sliding, force);
            }
        }
    }
    support.entries.retain(|entry| entry.until > step);
    forces
}
