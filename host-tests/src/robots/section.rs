//! What a robot has to say to a run: its section of a scenario, its nodes, its plant.

use super::NodeName;
use crate::bounds::Problem;
use crate::world::Plant;
use crate::world::terrain::Terrain;
use tautrack::link::MotorModel;
use tautrack::settings::Setting;

/// What a run is made of beside the robot.
#[derive(Clone, Copy, Debug)]
pub struct Conditions {
    /// Seed of all noise.
    pub seed: u64,
    /// Virtual time of the run, s.
    pub duration_s: f64,
    /// Coefficient of friction; of soft ground, its strength over the one that the guard is told.
    pub friction: f64,
    /// The ground.
    pub terrain: Terrain,
    /// The guard's filter limits the operator.
    pub guard: bool,
    /// The guard tells the drives the torques that it knows in advance.
    pub feed_forward: bool,
}

/// A robot's section of a scenario, `[robot.NAME]`.
pub trait Section {
    /// Checks its values, and that its plant has this ground.
    ///
    /// # Errors
    /// Names key, value and bound of the first bad one.
    fn check(&self, conditions: &Conditions) -> Result<(), Problem>;

    /// Foremost point of the robot at the start, m ahead of the world's origin.
    fn front_m(&self) -> f64;

    /// What the operator's word of posture is.
    fn posture(&self) -> Posture;

    /// Where a ground that only its plant has ends: x from and to, y from and to, m.
    fn extent(&self, _: &Terrain) -> Option<[[f64; 2]; 2]> {
        None
    }

    /// Its nodes: motors in the plant's order, then the guard.
    fn nodes(&self, conditions: &Conditions) -> Vec<NodeSpec>;

    /// The robot in its world.
    fn plant(&self, conditions: &Conditions) -> Box<dyn Plant>;
}

/// What is known of a robot without a scenario.
pub struct Facts {
    /// Its name in a sentence.
    pub name: &'static str,
    /// Names and ids of its nodes, in the plant's order, the guard last.
    pub nodes: &'static [(NodeName, u8)],
    /// The node program of its guard.
    pub guard_program: &'static str,
    /// Its scenario when none is named, in `host-tests/scenarios`.
    pub scenario_file: &'static str,
    /// Names of the stages in which its drives come to life.
    pub stages: &'static [&'static str],
    /// The channels of [`crate::world::truth::Truth::channels`] that a summary shows.
    pub headlines: &'static [&'static str],
    /// It stands when all its wheels, which have channels of their own, carry load.
    pub stands_on_wheels: bool,
    /// What the report says beside the curves of those channels.
    pub plots_note: &'static str,
    /// What the simulated robot stands for, and what of it is assumed.
    pub origin: &'static str,
}

/// What the operator's word of posture is, robot by robot.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Posture {
    /// There is none.
    None,
    /// Angle of the chassis joint, 2^-16 turns.
    ChassisAngle,
    /// Height of the hips above the wheels, mm.
    Clearance {
        /// Asked for at first, m.
        first_m: f64,
    },
    /// Height of the step ahead, mm. The guard passes on no word of its own.
    Step,
}

/// Which program a node runs.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Role {
    /// Closes the loops of one motor.
    Axle,
    /// An axle that keeps the belt taut.
    Screw,
    /// The robot's guard.
    Guard,
}

/// One node of a robot.
#[derive(Clone, Debug)]
pub struct NodeSpec {
    /// Name in the robot.
    pub name: NodeName,
    /// Its program.
    pub role: Role,
    /// `CANopen` node id.
    pub id: u8,
    /// What differs from the settings' defaults, beside the id.
    pub settings: Vec<(Setting, i32)>,
    /// Its motor; `None` for the guard.
    pub motor: Option<MotorModel>,
}

/// What a calibration left of the plants' declination and hard iron: off by up to 0.4 uT.
pub const SENSORS: &[(Setting, i32)] = &[
    (Setting::Declination, 1_000),
    (Setting::HardIronForward, 8_300),
    (Setting::HardIronLeft, -4_800),
    (Setting::HardIronUp, 12_400),
];

/// Place of a node among `nodes`, which is also its number on the virtual bus.
pub fn index_of(nodes: &[NodeSpec], name: NodeName) -> Option<usize> {
    nodes.iter().position(|node| node.name == name)
}
