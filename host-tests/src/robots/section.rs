//! Interface of a robot to a run: its section of a scenario file, its nodes and its plant.

use super::payload::Payload;
use super::{NodeName, motors};
use crate::bounds::Problem;
use crate::world::Plant;
use crate::world::terrain::Terrain;
use tautrack::link::MotorModel;
use tautrack::settings::Setting;
use tautrack_firmware::boards::host;

/// Conditions of a run that do not belong to the robot.
#[derive(Clone, Copy, Debug)]
pub struct Conditions {
    /// Seed of all noise.
    pub seed: u64,
    /// Virtual time of the run, s.
    pub duration_s: f64,
    /// Coefficient of friction; on soft ground, the ratio of its strength to the one in the guard's
    /// settings.
    pub friction: f64,
    /// Terrain of the run.
    pub terrain: Terrain,
    /// Whether the guard's filter limits the operator's commands.
    pub guard: bool,
    /// Whether the guard sends torque feed-forward to the drives.
    pub feed_forward: bool,
}

/// Section of a robot in a scenario file, `[robot.NAME]`.
pub trait Section {
    /// Checks the values, and that the robot's plant supports the terrain.
    ///
    /// # Errors
    /// [`Problem`] of the first bad value, with its key and bound.
    fn check(&self, conditions: &Conditions) -> Result<(), Problem>;

    /// Returns the load on the robot, if it has one.
    fn payload_mut(&mut self) -> Option<&mut Payload> {
        None
    }

    /// Position of the robot's foremost point at the start, m ahead of the world's origin.
    fn front_m(&self) -> f64;

    /// Meaning of the posture in the operator's command.
    fn posture(&self) -> Posture;

    /// Area of a ground that only this robot's plant has, m: minimum and maximum of x, then of y;
    /// `None` for other grounds.
    fn extent(&self, _: &Terrain) -> Option<[[f64; 2]; 2]> {
        None
    }

    /// Returns the robot's nodes: motors in the plant's order, then the guard.
    fn nodes(&self, conditions: &Conditions) -> Vec<NodeSpec>;

    /// Creates the plant: the robot on its ground.
    fn plant(&self, conditions: &Conditions) -> Box<dyn Plant>;
}

/// Facts about a robot that do not depend on a scenario.
pub struct Facts {
    /// Name of the robot, as used in sentences.
    pub name: &'static str,
    /// Names and ids of the nodes, in the plant's order; the guard is last.
    pub nodes: &'static [(NodeName, u8)],
    /// Name of the guard's node program.
    pub guard_program: &'static str,
    /// The guard in this process.
    pub guard: &'static host::Role,
    /// Default scenario file, relative to `host-tests/scenarios`.
    pub scenario_file: &'static str,
    /// Names of the stages in which the guard starts the drives.
    pub stages: &'static [&'static str],
    /// Channels of [`crate::world::truth::Truth::channels`] that a summary shows.
    pub headlines: &'static [&'static str],
    /// Whether the robot stands only if all its wheels carry load. Each wheel then has a load
    /// channel.
    pub stands_on_wheels: bool,
    /// Ends of the names of drives that follow rates. The other drives follow positions.
    pub follow_rates: &'static [&'static str],
    /// Whether a hand can hold and move the simulated robot.
    pub has_hand: bool,
    /// Text in the report beside the plots of the robot's channels.
    pub plots_note: &'static str,
    /// Text on the sources of the model, and on the values that are assumed.
    pub origin: &'static str,
}

/// Meaning of the posture in the operator's command, which depends on the robot.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Posture {
    /// The robot has no posture.
    None,
    /// Angle of the chassis joint, 2^-16 turns.
    ChassisAngle {
        /// Minimum and maximum of the joint's travel, rad.
        travel: [f64; 2],
    },
    /// Height of the hips above the wheels, mm.
    Clearance {
        /// Height commanded at first, m.
        first_m: f64,
    },
    /// Height of the step ahead, mm. The guard publishes no limited value for it.
    Step,
}

/// Role of a node.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Role {
    /// Control loops of one motor.
    Axle,
    /// Axle that keeps the belt taut.
    Screw,
    /// Guard of the robot.
    Guard,
}

impl Role {
    /// Name of the role in the firmware.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Axle => "axle",
            Self::Screw => "screw",
            Self::Guard => "guard",
        }
    }
}

/// Specification of one node of a robot.
#[derive(Clone, Debug)]
pub struct NodeSpec {
    /// Name of the node in the robot.
    pub name: NodeName,
    /// Role of the node.
    pub role: Role,
    /// `CANopen` node id.
    pub id: u8,
    /// Settings that differ from the defaults, without the node id.
    pub settings: Vec<(Setting, i32)>,
    /// Motor of the node; `None` for the guard. [`NodeSpec::set_motor`] sets it.
    pub motor: Option<MotorModel>,
}

impl NodeSpec {
    /// Returns the node with this motor, as [`Self::set_motor`] sets it.
    #[must_use]
    pub fn with_motor(mut self, motor: Option<MotorModel>) -> Self {
        self.set_motor(motor);
        self
    }

    /// Sets the motor, and those settings with which the node drives it.
    pub fn set_motor(&mut self, motor: Option<MotorModel>) {
        self.motor = motor;
        let Some(motor) = motor else { return };
        let derived = motors::settings(&motor);
        self.settings
            .retain(|(known, _)| derived.iter().all(|(setting, _)| setting != known));
        self.settings.splice(0..0, derived);
    }
}

/// Compass settings of the guards: declination and hard iron of the plants, as a calibration would
/// find them, with errors of up to 0.4 uT.
pub const SENSORS: &[(Setting, i32)] = &[
    (Setting::Declination, 1_000),
    (Setting::HardIronForward, 8_300),
    (Setting::HardIronLeft, -4_800),
    (Setting::HardIronUp, 12_400),
];

/// Index of a node in `nodes`, which is also its number on the virtual bus.
pub fn index_of(nodes: &[NodeSpec], name: NodeName) -> Option<usize> {
    nodes.iter().position(|node| node.name == name)
}
