//! The description of a run that all draws start from.

use super::generator::Random;
use crate::robots::Robot;
use crate::scenario::{Description, Expect, Operator, Sensors};
use crate::world::terrain::Terrain;
use std::collections::BTreeMap;

/// Draws the common description: the default robot on good ground, driving slowly.
pub fn beginning(random: &mut Random) -> Description {
    Description {
        feed_forward: true,
        name: String::new(),
        about: String::new(),
        seed: random.bits() >> 32,
        duration_s: 14.0,
        guard: true,
        friction: random.between(1.0, 1.2),
        terrain: Terrain::Flat,
        robot: Robot::nominal(random.between(0.5, 3.0)),
        operator: Operator {
            client: false,
            from_power_up: false,
            speed_mps: random.between(0.08, 0.18),
            chassis_deg: 45.0,
            step_m: 0.0,
            chassis_rate_deg_s: 28.6,
            heading_gain_per_s: 1.0,
            belts: None,
            clearance: None,
            request: None,
            events: Vec::new(),
        },
        motors: BTreeMap::new(),
        sensors: Sensors::default(),
        settings: BTreeMap::new(),
        faults: Vec::new(),
        frames: Vec::new(),
        hand: Vec::new(),
        expect: Expect::default(),
    }
}
