//! Puts RT-Mover and its ground into the physics engine.

use super::robot::{Robot, SEAT};
use super::{MOTORS, RtMover, RtMoverParameters};
use crate::world::gear::Gear;
use crate::world::ground::Ground;
use crate::world::noise::Noise;
use crate::world::physics::{turn, world};
use crate::world::sensing::BodySensing;
use crate::world::truth::Truth;
use core::f64::consts::TAU;
use rapier3d_f64::math::{Pose, Vector};
use rapier3d_f64::prelude::*;

impl RtMover {
    /// Creates the robot at the origin of `terrain`; `seed` is the seed of the sensor noise.
    pub fn new(parameters: &RtMoverParameters, terrain: &Ground, seed: u64) -> Self {
        let p = *parameters;
        let mut world = world();
        let [pitch, roll] = terrain.inclination();
        let tilt = Pose::from_rotation(turn(Vector::NEG_Y, pitch) * turn(Vector::X, roll));
        for block in terrain.blocks() {
            let [x, y, z] = block.half;
            let lie = Pose::from_parts(
                Vector::from_array(block.centre),
                turn(Vector::NEG_Y, block.pitch),
            );
            world.insert_collider(
                ColliderBuilder::cuboid(x, y, z)
                    .position(tilt * lie)
                    .friction(p.friction),
                None,
            );
        }
        let robot = Robot::build(&mut world, &p, tilt);
        let seat = &world.bodies[robot.bodies[SEAT]];
        let sensing = BodySensing::new(&p.body_sensors, Noise::new(seed), seat.position().rotation);
        let mut plant = Self {
            gears: core::array::from_fn(|motor| {
                if motor < 4 {
                    Gear::new([0.0, p.wheel_gear], TAU, Some(p.dead_wheel_friction), 0.0)
                } else {
                    Gear::new(p.shaft_gear, TAU, None, 0.0)
                }
            }),
            rates: [0.0; MOTORS],
            step: 0,
            terrain: *terrain,
            up: (tilt.rotation * Vector::Z).to_array(),
            lowest: [Vector::ZERO; 4],
            loads: [0.0; 4],
            standing_until: [0; 4],
            payload: None,
            truth: Truth::default(),
            parameters: p,
            world,
            robot,
            sensing,
        };
        plant.observe();
        plant
    }
}
