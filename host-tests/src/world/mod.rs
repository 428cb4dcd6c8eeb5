//! Physical world that the nodes move and measure. The trait [`Plant`] is the interface of one
//! robot's simulated physics.
//!
//! A motor and its rotor are simulated in the node that drives them; a plant begins at the output
//! shaft of the gear. [`terrain`] is the terrain in a scenario, [`ground`] the ground built from
//! it, [`grid`] the lines from which it is drawn, [`load`] a robot's payload, [`inertia`] the mass
//! and inertia of a body, [`physics`] the settings of the physics engine, [`gear`] the connection
//! of a node's shaft to its load, [`sensing`] the sensors on a body, [`sensor_board`] how their
//! board is mounted and their constant errors, [`gnss`] the GNSS receiver, [`noise`] the seeded
//! noise, [`hand`] a hand that moves the robot, [`truth`] the ground truth.

pub mod gear;
pub mod gnss;
pub mod grid;
pub mod ground;
pub mod hand;
pub mod inertia;
pub mod load;
pub mod noise;
pub mod physics;
pub mod sensing;
pub mod sensor_board;
pub mod terrain;
pub mod truth;

use crate::world::hand::Held;
use crate::world::truth::{BodyPose, BodyShape, Sketch, Strip, Truth};
use tautrack::link::{BodyMeasurands, Sensors, Shaft};

/// Fault of a track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackFault {
    /// Whether the belt is off its sprocket.
    pub belt_off: bool,
    /// Coefficient of friction of the ground under the belt, if the ground's is not below it.
    pub friction: f64,
}

impl TrackFault {
    /// No fault.
    pub const NONE: Self = Self {
        belt_off: false,
        friction: f64::INFINITY,
    };
}

/// A robot and its surroundings, advanced in steps of one millisecond
/// ([`tautrack::link::STEP_US`]).
///
/// It is deterministic: with the same construction and the same shaft motions, its state is
/// bit-identical on every machine.
pub trait Plant {
    /// Advances by one millisecond. `shafts` has one entry per motor: `shafts[i]` is the motion of
    /// motor i's output shaft at the end of this step, as its node reports it. `None` means a dead
    /// node, whose bridge is off and whose axle moves only against the friction of its gear. A node
    /// that restarts may count from zero again; its axle continues from its current place.
    fn step(&mut self, shafts: &[Option<Shaft>]);

    /// Holds the robot's body in this posture during the next step; `None` lets go of it. Only the
    /// plant of a robot that has a hand does it.
    fn hold(&mut self, _: Option<&Held>) {}

    /// Lets the track of motor number `motor` have this fault from the next step on. Only the plant
    /// of B2P2 does it.
    fn set_track_fault(&mut self, _motor: usize, _fault: TrackFault) {}

    /// Sensor readings of the board of motor number `motor` after the last step. `body` is `None`,
    /// because only the guard's board has the sensors on the body.
    ///
    /// # Panics
    /// If there is no such motor.
    fn sensors(&self, motor: usize) -> Sensors;

    /// What acts on the sensors on the robot's body after the last step, without faults.
    fn body_sensors(&self) -> BodyMeasurands;

    /// Bytes that the GNSS receiver put on the guard's serial line in the last step.
    fn serial(&self) -> &[u8] {
        &[]
    }

    /// How to draw the robot; empty for a robot that has its own drawing.
    fn sketch(&self) -> Sketch {
        Sketch::default()
    }

    /// Forces of the ground on the robot in the last step: place, m, and force, N, in world axes.
    fn forces(&self) -> Vec<[[f64; 3]; 2]> {
        Vec::new()
    }

    /// Belts of the robot as they lie.
    fn belts(&self) -> Vec<Strip> {
        Vec::new()
    }

    /// Rigid bodies of the robot, in the order of [`Plant::poses`].
    fn bodies(&self) -> Vec<BodyShape>;

    /// Poses of the bodies in the world after the last step.
    fn poses(&self) -> Vec<BodyPose>;

    /// Height of the ground at a place (x and y), m.
    fn ground_height(&self, place: [f64; 2]) -> f64;

    /// Distances from a place along a direction at which the ground may have a step, m.
    fn ground_edges(&self, _from: [f64; 2], _direction: [f64; 2]) -> Vec<f64> {
        Vec::new()
    }

    /// Ground truth after the last step; no node may see it.
    fn truth(&self) -> &Truth;

    /// Passes every bit of the physical state to `sink`, in a fixed order, for the hash of a run.
    fn truth_bits(&self, sink: &mut dyn FnMut(&[u8]));
}
