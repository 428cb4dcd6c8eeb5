//! What the physics knows of the robot.

use super::Hylos;
use crate::plant::b2p2::robot::GRAVITY;
use rapier3d_f64::math::Vector;
use tautrack::robots::hylos::LEGS;
use tautrack::robots::hylos::stability::AROUND;
use tautrack::stability::tipover::{angles, margin};

/// How long a wheel that carried force counts as standing, steps: single contacts flicker.
const WINDOW: u64 = 50;
/// Least force of a wheel that stands, N.
const LEAST_SUPPORT: f64 = 0.5;
/// Cosine of the angle between platform and ground from which the robot has tipped over.
const TIPPED: f64 = 0.5;

/// State of the plant: metres, radians and newtons; x forward, y left, z up.
#[derive(Clone, Debug, Default)]
pub struct HylosTruth {
    /// Middle of the platform in the world.
    pub place: [f64; 3],
    /// Heading, counter-clockwise from above.
    pub yaw: f64,
    /// What is up, in the platform's axes.
    pub up: [f64; 3],
    /// Hips and knees.
    pub legs: [[f64; 2]; LEGS],
    /// Steering angles.
    pub steering: [f64; LEGS],
    /// Torques of the hips' and knees' gears, positive the way their joints count, N m.
    pub leg_torques: [[f64; 2]; LEGS],
    /// Force of the ground on each wheel along its normal.
    pub wheel_forces: [f64; LEGS],
    /// Whether each wheel carried force within the last 50 ms.
    pub standing: [bool; LEGS],
    /// Centre of gravity in the world.
    pub cog: [f64; 3],
    /// Lowest point of each wheel over the ground, whether it stands or not.
    pub contacts: [[f64; 3]; LEGS],
    /// Least tip-over angle of the weight about the lines between neighbouring wheels' contacts, negative once it tips.
    pub margin: f64,
    /// Turned over; stays set.
    pub toppled: bool,
}

impl Hylos {
    /// Brings the truth up to date after a step.
    pub(super) fn observe(&mut self) {
        let (p, world, robot) = (&self.parameters, &self.world, &self.robot);
        let platform = &world.bodies[robot.platform];
        let pose = platform.position();
        let truth = &mut self.truth;
        truth.place = pose.translation.to_array();
        truth.up = (pose.rotation.inverse() * Vector::Z).to_array();
        let forward = pose.rotation * Vector::X;
        truth.yaw = libm::atan2(forward.y, forward.x);

        truth.wheel_forces = robot.wheel_forces(world);
        let mut moment = pose.transform_point(Vector::from_array(p.measures.platform_com))
            * p.measures.platform_mass;
        let mut mass = p.measures.platform_mass;
        for leg in 0..LEGS {
            truth.legs[leg] = p.joints(robot.reach(world, p, leg));
            truth.steering[leg] = robot.steering(world, leg);
            truth.leg_torques[leg] = [0, 1].map(|joint| self.leg_torques[leg][joint]);
            if truth.wheel_forces[leg] > LEAST_SUPPORT {
                self.standing_until[leg] = self.step + WINDOW;
            }
            truth.standing[leg] = self.standing_until[leg] > self.step;

            let carrier = world.bodies[robot.carriers[leg]].position();
            let (hub, axle) = (carrier.translation, carrier.rotation * Vector::Y);
            moment += hub * p.measures.wheel_mass;
            mass += p.measures.wheel_mass;
            let normal = Vector::from_array(self.hillside.normal([hub.x, hub.y]));
            let across = (normal - axle * normal.dot(axle)).normalize_or_zero();
            truth.contacts[leg] = (hub - across * p.measures.wheel_radius).to_array();
        }
        let cog = moment / mass;
        truth.cog = cog.to_array();
        let around = AROUND.map(|leg| truth.contacts[leg]);
        let weight = [0.0, 0.0, -mass * GRAVITY];
        truth.margin = margin(&angles(&around, truth.cog, weight, [0.0; 3]));
        let ground = Vector::from_array(self.hillside.normal([truth.place[0], truth.place[1]]));
        truth.toppled |= (pose.rotation * Vector::Z).dot(ground) < TIPPED;
    }
}
