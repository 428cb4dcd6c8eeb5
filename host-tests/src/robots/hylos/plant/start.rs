//! Puts Hylos and its ground into the physics engine.

use super::robot::Robot;
use super::{Detail, Hillside, Hylos, HylosParameters, LEGS};
use crate::world::gear::Gear;
use crate::world::noise::Noise;
use crate::world::physics::world;
use crate::world::sensing::BodySensing;
use crate::world::truth::Truth;
use core::f64::consts::TAU;
use rapier3d_f64::math::Vector;

impl Hylos {
    /// Creates the robot at the place in its parameters; `seed` is the seed of the sensor noise.
    pub fn new(parameters: &HylosParameters, hillside: &Hillside, seed: u64) -> Self {
        let p = *parameters;
        let mut world = world();
        world.insert_collider(hillside.collider(p.friction), None);
        let below = [p.start[0], p.start[1]];
        let robot = Robot::build(
            &mut world,
            &p,
            hillside.height(below),
            Vector::from_array(hillside.normal(below)),
        );
        // The stiffness of hip and knee is zero here, because `leg_gear` models it at the wheel.
        let leg = |place| Gear::new([0.0; 2], TAU, None, place);
        let steering = || Gear::new(p.steering_gear, TAU, Some(p.dead_friction[0]), 0.0);
        let body_sensing = BodySensing::new(
            &p.body_sensors,
            Noise::new(seed),
            world.bodies[robot.platform].position().rotation,
        );
        let mut plant = Self {
            gears: core::array::from_fn(|_| {
                [leg(p.initial_leg[0]), leg(p.initial_leg[1]), steering()]
            }),
            driven: [false; LEGS],
            leg_torques: [[0.0; 2]; LEGS],
            standing_until: [0; LEGS],
            body_sensing,
            step: 0,
            truth: Truth::default(),
            detail: Detail::default(),
            hillside: *hillside,
            parameters: p,
            world,
            robot,
        };
        plant.observe();
        plant
    }
}
