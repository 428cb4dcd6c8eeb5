//! The physical world that the nodes move and sense: one plant per robot, behind one trait.
//!
//! A motor and its rotor live in the node that drives them; a plant begins at the output shaft of the gear.
//! [`terrain`] is the ground in a scenario, [`ground`] the ground that it makes, [`load`] what a robot carries, [`physics`] the physics
//! engine's settings, [`gear`] where a node's shaft meets the load, [`sensing`] the sensors on a body, [`gnss`] the satellite
//! receiver, [`noise`] the seeded randomness, [`truth`] what the physics knows.

pub mod gear;
pub mod gnss;
pub mod ground;
pub mod load;
pub mod noise;
pub mod physics;
pub mod sensing;
pub mod terrain;
pub mod truth;

use crate::world::truth::{BodyPose, BodyShape, Sketch, Truth};
use tautrack::link::{Sensors, Shaft};
use tautrack::sensors::BodySensors;

/// A robot and the world around it, advanced in steps of one millisecond ([`tautrack::link::STEP_US`]).
///
/// Deterministic: the same construction and the same shafts give the same bits on every machine.
pub trait Plant {
    /// Advances by one millisecond; one shaft for each motor. `shafts[i]` is the motion of motor i's output shaft at the end of this step, as its
    /// node reports it; `None` is a dead node, whose bridge is off and whose axle moves against its gear's friction alone.
    /// A node that comes back may count from zero again: its axle continues from where it is.
    fn step(&mut self, shafts: &[Option<Shaft>]);

    /// What the board of motor `motor` senses after the last step; `body` is `None`, it sits on the guard's board alone.
    ///
    /// # Panics
    /// If there is no such motor.
    fn sensors(&self, motor: usize) -> Sensors;

    /// What the sensors on the robot's body say after the last step.
    fn body_sensors(&self) -> BodySensors;

    /// Bytes that the GNSS receiver put on the guard's serial line in the last step.
    fn serial(&self) -> &[u8] {
        &[]
    }

    /// How the robot is drawn; B2P2 has a picture of its own.
    fn sketch(&self) -> Sketch {
        Sketch::default()
    }

    /// Rigid bodies of the robot, in the order of [`Plant::poses`].
    fn bodies(&self) -> Vec<BodyShape>;

    /// Poses of the bodies in the world after the last step.
    fn poses(&self) -> Vec<BodyPose>;

    /// Height of the ground over a place (x and y), m.
    fn ground_height(&self, place: [f64; 2]) -> f64;

    /// Distances from a place along a direction at which the ground may have a step, m.
    fn ground_edges(&self, _from: [f64; 2], _direction: [f64; 2]) -> Vec<f64> {
        Vec::new()
    }

    /// What the physics knows after the last step; no node may see it.
    fn truth(&self) -> &Truth;

    /// Hands over every bit of the physical state, in a fixed order, for the hash of a run.
    fn truth_bits(&self, sink: &mut dyn FnMut(&[u8]));
}
