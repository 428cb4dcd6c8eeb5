//! Makes bodies and joints of the cart in the physics engine.

use crate::world::gear::Drive;
use crate::world::physics::{DT, SUBSTEPS};
use rapier3d_f64::math::{Pose, Vector};
use rapier3d_f64::prelude::*;
use tautrack::robots::cart::parameters::CART;

/// Half the width of a wheel, radius of the caster and radius of the mast's head, m.
pub const HALF_WIDTH: f64 = 0.005;
pub const CASTER_RADIUS: f64 = 0.03;
pub const HEAD_RADIUS: f64 = 0.05;

/// Handles of the cart's parts in the physics engine.
pub struct Robot {
    /// Chassis with caster and mast.
    pub chassis: RigidBodyHandle,
    /// Left and right wheel.
    pub wheels: [RigidBodyHandle; 2],
    axles: [ImpulseJointHandle; 2],
    /// Colliders of left wheel, right wheel and caster.
    touching: [ColliderHandle; 3],
}

/// Principal inertia of a box of even density.
fn cuboid(mass: f64, [x, y, z]: [f64; 3]) -> Vector {
    Vector::new(y * y + z * z, x * x + z * z, x * x + y * y) * (mass / 12.0)
}

/// Mass and inertia of the chassis with the mast's head at height `mast`, m.
fn properties(mast: f64) -> MassProperties {
    let chassis = Vector::new(-CART.behind, 0.0, CART.chassis_height);
    let head = Vector::new(-CART.behind, 0.0, mast);
    let ball = Vector::splat(0.4 * CART.head_mass * HEAD_RADIUS * HEAD_RADIUS);
    MassProperties::new(
        chassis,
        CART.chassis_mass,
        cuboid(CART.chassis_mass, CART.chassis_size),
    ) + MassProperties::new(head, CART.head_mass, ball)
}

impl Robot {
    /// Builds the cart with its axle above the origin, on the plane through the origin with
    /// inclination `tilt`.
    pub fn build(world: &mut PhysicsWorld, mast: f64, friction: f64, tilt: Pose) -> Self {
        let mut body = |place: Vector, properties: MassProperties| {
            world.insert_body(
                RigidBodyBuilder::dynamic()
                    .pose(tilt * Pose::from_translation(place))
                    .additional_mass_properties(properties)
                    .can_sleep(false),
            )
        };
        let radius = CART.wheel_radius;
        let disc = 0.5 * CART.wheel_mass * radius * radius;
        let inertia = Vector::new(0.5 * disc, disc, 0.5 * disc);
        let hubs = [0.5, -0.5].map(|side| Vector::new(0.0, side * CART.gauge, radius));
        let chassis = body(Vector::ZERO, properties(mast));
        let wheels = hubs.map(|hub| {
            body(
                hub,
                MassProperties::new(Vector::ZERO, CART.wheel_mass, inertia),
            )
        });
        let axles = [0, 1].map(|side: usize| {
            world.insert_impulse_joint(
                chassis,
                wheels[side],
                RevoluteJointBuilder::new(Vector::Y)
                    .local_anchor1(hubs[side])
                    .local_anchor2(Vector::ZERO)
                    .motor_model(MotorModel::ForceBased),
            )
        });
        let mut touch = |shape: ColliderBuilder, friction: f64, parent: RigidBodyHandle| {
            world.insert_collider(
                shape
                    .density(0.0)
                    .friction(friction)
                    .friction_combine_rule(CoefficientCombineRule::Min)
                    // The cart touches the ground, but not itself.
                    .collision_groups(InteractionGroups::new(
                        Group::GROUP_2,
                        Group::GROUP_1,
                        InteractionTestMode::And,
                    )),
                Some(parent),
            )
        };
        let wheel = || ColliderBuilder::cylinder(HALF_WIDTH, radius);
        let [left, right] = wheels.map(|body| touch(wheel(), friction, body));
        let ball = |radius: f64, x: f64, z: f64| {
            ColliderBuilder::ball(radius).translation(Vector::new(x, 0.0, z))
        };
        let caster = touch(
            ball(CASTER_RADIUS, -CART.caster, CASTER_RADIUS),
            0.0,
            chassis,
        );
        touch(ball(HEAD_RADIUS, -CART.behind, mast), friction, chassis);
        Self {
            chassis,
            wheels,
            axles,
            touching: [left, right, caster],
        }
    }

    /// Sets the motor of a wheel for the next step.
    pub fn drive(&self, world: &mut PhysicsWorld, side: usize, drive: Drive) {
        // The handle is valid as long as the world exists.
        if let Some(joint) = world.impulse_joints.get_mut(self.axles[side], false) {
            let [stiffness, damping] = drive.stiffness;
            let axis = JointAxis::AngX;
            joint
                .data
                .set_motor(axis, drive.place, drive.speed, stiffness, damping);
            joint.data.set_motor_max_force(axis, drive.limit);
        }
    }

    /// Torque that the gear of a wheel transmitted in the last substep, N m.
    pub fn passed_on(&self, world: &PhysicsWorld, side: usize) -> f64 {
        let joint = world.impulse_joints.get(self.axles[side]);
        let motor = joint.and_then(|joint| joint.data.motor(JointAxis::AngX));
        motor.map_or(0.0, |motor| -motor.impulse * SUBSTEPS as f64 / DT)
    }

    /// Rate of a wheel relative to the chassis, rad/s.
    pub fn rate(&self, world: &PhysicsWorld, side: usize) -> f64 {
        let [chassis, wheel] = [self.chassis, self.wheels[side]].map(|body| &world.bodies[body]);
        (wheel.angvel() - chassis.angvel()).dot(chassis.position().rotation * Vector::Y)
    }

    /// Lowest points of left wheel, right wheel and caster. `up` is the normal of the ground.
    pub fn lowest(&self, world: &PhysicsWorld, up: Vector) -> [Vector; 3] {
        let [left, right] = self.wheels.map(|wheel| {
            let pose = world.bodies[wheel].position();
            let axle = pose.rotation * Vector::Y;
            let down = axle * up.dot(axle) - up;
            pose.translation + down.normalize_or_zero() * CART.wheel_radius
        });
        let centre = Vector::new(-CART.caster, 0.0, CASTER_RADIUS);
        let caster = world.bodies[self.chassis]
            .position()
            .transform_point(centre);
        [left, right, caster - up * CASTER_RADIUS]
    }

    /// Whether left wheel, right wheel and caster carried force in the last step.
    pub fn carrying(&self, world: &PhysicsWorld) -> [bool; 3] {
        let mut carrying = [false; 3];
        for pair in world.contact_pairs() {
            let own = |handle| self.touching.iter().position(|other| *other == handle);
            let Some(place) = own(pair.collider1).or(own(pair.collider2)) else {
                continue;
            };
            let mut manifolds = pair.solver_manifolds().iter();
            carrying[place] |= manifolds
                .any(|manifold| manifold.points.iter().any(|point| point.data.impulse > 0.0));
        }
        carrying
    }
}
