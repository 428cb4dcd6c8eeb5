//! The physical world that the nodes move and sense: one plant per robot, behind one trait.
//!
//! A motor and its rotor live in the node that drives them; a plant begins at the output shaft of the gear.
//! [`b2p2`] is the tracked robot of Paillat et al., [`rt_mover`] the leg-wheel robot of Nakajima, [`terrain`] what it drives on, [`noise`] the seeded randomness.

pub mod b2p2;
pub mod noise;
pub mod rt_mover;
pub mod terrain;

use crate::record::Truth;
use tautrack::link::{BodySensors, Sensors, Shaft};

/// Motors of a plant, in the order of its nodes: left track, right track, chassis joint, screw.
pub const MOTORS: usize = 4;

/// A robot and the world around it, advanced in steps of one millisecond ([`tautrack::link::STEP_US`]).
///
/// Deterministic: the same construction and the same shafts give the same bits on every machine.
pub trait Plant {
    /// Advances by one millisecond. `shafts[i]` is the motion of motor i's output shaft at the end of this step, as its
    /// node reports it; `None` is a dead node, whose bridge is off and whose axle moves against its gear's friction alone.
    /// A node that comes back may count from zero again: its axle continues from where it is.
    fn step(&mut self, shafts: &[Option<Shaft>; MOTORS]);

    /// What the board of motor `motor` senses after the last step; `body` is `None`, it sits on the guard's board alone.
    ///
    /// # Panics
    /// If `motor` is not below [`MOTORS`].
    fn sensors(&self, motor: usize) -> Sensors;

    /// What the sensors on the robot's body say after the last step.
    fn body_sensors(&self) -> BodySensors;

    /// What the physics knows after the last step; no node may see it.
    fn truth(&self) -> &Truth;

    /// Hands over every bit of the physical state, in a fixed order, for the hash of a run.
    fn truth_bits(&self, sink: &mut dyn FnMut(&[u8]));
}
