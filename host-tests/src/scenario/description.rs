//! A scenario file as written.

use super::{Expect, Fault, Operator, driver};
use crate::robots::{Conditions, Kind, NodeName, NodeSpec, Robot};
use crate::world::Plant;
use crate::world::terrain::Terrain;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use tautrack::settings::Setting;

/// A scenario file as written. Axes as in [`crate::world::truth::Truth`]; axle 1 starts at x = 0, y
/// = 0, heading 0.
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
    /// Whether the guard's filter limits the operator. Off, it passes every command on.
    #[serde(default = "on")]
    pub guard: bool,
    /// Whether the guard tells the drives the torques that it knows in advance.
    #[serde(default = "on")]
    pub feed_forward: bool,
    /// Coefficient of friction between track and ground; of the crawler's soft ground, its strength
    /// over the one that the guard is told.
    pub friction: f64,
    /// The ground.
    pub terrain: Terrain,
    /// The robot, and what its paper leaves open; B2P2's nominal stand-in where none is named.
    #[serde(default)]
    pub robot: Robot,
    /// Settings of nodes that differ from those of the robot: node, name, value in the setting's
    /// unit. The plant does not know of them.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub settings: BTreeMap<NodeName, BTreeMap<String, i32>>,
    /// Who drives.
    #[serde(with = "driver")]
    pub operator: Operator,
    /// What goes wrong.
    #[serde(default, rename = "fault")]
    pub faults: Vec<Fault>,
    /// What must come out.
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

    /// What the run is made of beside the robot.
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

    /// The robot in its world.
    pub fn plant(&self) -> Box<dyn Plant> {
        self.robot.section().plant(&self.conditions())
    }
}
