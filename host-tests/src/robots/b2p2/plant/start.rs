//! Puts B2P2 and its ground into the physics engine.

use super::belt::Belts;
use super::contact::{GroundForces, Support};
use super::robot::{self, Robot};
use super::{B2p2, B2p2Parameters};
use crate::world::TrackFault;
use crate::world::gear::{Gear, Sprocket};
use crate::world::gnss::Receiver;
use crate::world::ground::Ground;
use crate::world::hand::Grip;
use crate::world::noise::Noise;
use crate::world::physics;
use crate::world::sensing::BodySensing;
use crate::world::truth::Truth;
use core::f64::consts::TAU;
use rapier3d_f64::math::Vector;

impl B2p2 {
    /// Creates the robot at the origin of `terrain`, with the posture and place of the parameters;
    /// `seed` is the seed of the sensor noise.
    pub fn new(parameters: &B2p2Parameters, terrain: &Ground, seed: u64) -> Self {
        let p = *parameters;
        let mut world = physics::world();
        let start = robot::lay_ground(&mut world, terrain, &p);
        let robot = Robot::build(&mut world, &p, start);
        let up = (start.rotation * Vector::Z).to_array();
        let body_sensing = BodySensing::new(
            &p.body_sensors,
            Noise::new(seed),
            world.bodies[robot.bodies[0]].position().rotation,
        );
        let mut plant = Self {
            joint: Gear::new(
                p.joint_gear,
                TAU,
                Some(p.dead_joint_friction),
                p.initial_theta,
            ),
            screw: Gear::new(p.screw_gear, p.screw_lead, None, p.initial_extension()),
            sprockets: [Sprocket::default(); 2],
            track_faults: [TrackFault::NONE; 2],
            belts: Belts::new(terrain),
            support: Support::default(),
            ground: GroundForces::default(),
            rates: [0.0; 2],
            receiver: Receiver::new(p.receiver, Noise::new(seed)),
            step: 0,
            payload: None,
            grip: Grip::default(),
            terrain: *terrain,
            up,
            truth: Truth::default(),
            parameters: p,
            world,
            robot,
            body_sensing,
        };
        plant.observe();
        plant
    }
}
