//! The robots as a run sees them: which nodes there are, what each is told about itself, and which plant they move.
//!
//! One file per robot; a new one is a variant of [`Kind`] and a line in [`machine`].

pub mod b2p2;

use crate::plant::Plant;
use crate::scenario::{NodeName, Scenario};
use clap::ValueEnum;
use tautrack::link::MotorModel;
use tautrack::robots::{self, Body};
use tautrack::settings::Setting;

/// The robots.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, ValueEnum)]
pub enum Kind {
    /// Tracked, variable geometry (Paillat et al.)
    #[default]
    B2p2,
}

impl Kind {
    /// The node program of its guard.
    pub fn guard_program(self) -> &'static str {
        match self {
            Self::B2p2 => "guard",
        }
    }

    /// Its scenario when none is named, in `host-tests/scenarios`.
    pub fn scenario_file(self) -> &'static str {
        match self {
            Self::B2p2 => "staircase.toml",
        }
    }

    /// Names of the stages in which its drives come to life.
    pub fn stages(self) -> &'static [&'static str] {
        match self {
            Self::B2p2 => robots::b2p2::B2p2::STAGES,
        }
    }
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

/// A robot in its world: motors in the plant's order, then the guard.
pub struct Machine {
    /// Which robot.
    pub kind: Kind,
    /// Its nodes, the guard last.
    pub nodes: Vec<NodeSpec>,
    /// The world.
    pub plant: Box<dyn Plant>,
}

/// The robot of `scenario` in its world.
pub fn machine(scenario: &Scenario) -> Machine {
    match scenario.kind() {
        kind @ Kind::B2p2 => Machine {
            kind,
            nodes: b2p2::nodes(scenario),
            plant: b2p2::plant(scenario),
        },
    }
}

/// Place of a node among `nodes`, which is also its number on the virtual bus.
pub fn index_of(nodes: &[NodeSpec], name: NodeName) -> Option<usize> {
    nodes.iter().position(|node| node.name == name)
}
