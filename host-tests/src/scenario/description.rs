//! The content of a scenario file, before it is checked.

use super::{ClientFrame, Expect, Fault, Motion, Motor, Operator, Sensors, driver, hand};
use crate::robots::{Conditions, Kind, NodeName, NodeSpec, Robot};
use crate::world::Plant;
use crate::world::hand::Path;
use crate::world::terrain::Terrain;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use tautrack::settings::Setting;

/// The content of a scenario file, before it is checked. World axes are those of
/// [`crate::world::truth::Truth`]; axle 1 starts at x = 0, y = 0, with heading 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// Name of the run, as reports show it.
    pub name: String,
    /// What the run shows, one or two sentences.
    pub about: String,
    /// Seed of all noise and of all random faults.
    pub seed: u64,
    /// Virtual time to run, s.
    pub duration_s: f64,
    /// Whether the guard's filter limits the operator's commands. Without it the guard passes every
    /// command on.
    #[serde(default = "on")]
    pub guard: bool,
    /// Whether the guard sends the drives torque feed-forward.
    #[serde(default = "on")]
    pub feed_forward: bool,
    /// Coefficient of friction between track and ground. On the crawler's soft ground: strength of
    /// the simulated soil as a multiple of the one in the guard's settings.
    pub friction: f64,
    /// The ground.
    pub terrain: Terrain,
    /// The robot, and the parameters that its paper does not give. By default the default robot
    /// with nominal parameters.
    #[serde(default)]
    pub robot: Robot,
    /// Motors that differ from those of the robot.
    #[serde(default, rename = "motor", skip_serializing_if = "BTreeMap::is_empty")]
    pub motors: BTreeMap<NodeName, Motor>,
    /// Rates of the sensors on the body.
    #[serde(default, skip_serializing_if = "Sensors::usual")]
    pub sensors: Sensors,
    /// Settings of nodes that differ from those of the robot: node, setting's name, value in the
    /// setting's unit. They change what the node assumes, not the plant.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub settings: BTreeMap<NodeName, BTreeMap<String, i32>>,
    /// The operator: a script, or a client on the bus.
    #[serde(with = "driver")]
    pub operator: Operator,
    /// Faults that the run injects.
    #[serde(default, rename = "fault")]
    pub faults: Vec<Fault>,
    /// Frames that a client on the bus sends.
    #[serde(default, rename = "frame", skip_serializing_if = "Vec::is_empty")]
    pub frames: Vec<ClientFrame>,
    /// Motions of a hand that lifts, tilts and turns the robot.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hand: Vec<Motion>,
    /// What the run must result in.
    #[serde(default)]
    pub expect: Expect,
}

fn on() -> bool {
    true
}

impl Description {
    /// Which robot it is.
    pub fn kind(&self) -> Kind {
        self.robot.kind()
    }

    /// The conditions of the run apart from the robot.
    pub fn conditions(&self) -> Conditions {
        Conditions {
            seed: self.seed,
            duration_s: self.duration_s,
            friction: self.friction,
            terrain: self.terrain,
            guard: self.guard,
            feed_forward: self.feed_forward,
        }
    }

    /// The robot's nodes: motors in the plant's order, then the guard.
    pub fn nodes(&self) -> Vec<NodeSpec> {
        let mut nodes = self.robot.section().nodes(&self.conditions());
        for node in &mut nodes {
            if let Some(motor) = self.motors.get(&node.name) {
                node.set_motor(node.motor.map(|model| motor.apply(&model)));
            }
            if node.name == NodeName::GUARD && !self.sensors.usual() {
                node.settings.extend(self.sensors.settings());
            }
            for (name, value) in self.settings.get(&node.name).into_iter().flatten() {
                let Some(setting) = Setting::from_name(name) else {
                    continue;
                };
                node.settings.retain(|(known, _)| *known != setting);
                node.settings.push((setting, *value));
            }
        }
        nodes
    }

    /// Path of the hand.
    pub fn hand(&self) -> Path {
        hand::path(&self.hand)
    }

    /// The simulated robot on its ground.
    pub fn plant(&self) -> Box<dyn Plant> {
        self.robot.section().plant(&self.conditions())
    }
}
