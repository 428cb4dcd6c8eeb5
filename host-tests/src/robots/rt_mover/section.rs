//! Section of a scenario file for RT-Mover: the values in which it differs from the robot of the
//! library, and their bounds.

use super::nodes;
use super::plant::{self, RtMoverParameters};
use crate::bounds::{Problem, contradiction};
use crate::robots::payload::Payload;
use crate::robots::{Conditions, NodeSpec, Posture, Section};
use crate::world::Plant;
use crate::world::terrain::Terrain;
use serde::{Deserialize, Serialize};
use tautrack::robots::rt_mover::parameters::{BODY_LENGTH, WHEEL_RADIUS};

/// Section `[robot.rt_mover]` of the leg-wheel robot. An empty section is the robot of the library.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RtMover {
    /// Load on the seat; its place is relative to the middle of the body.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub payload: Option<Payload>,
}

impl RtMover {
    /// Parameters of the plant, on ground with this coefficient of friction.
    pub fn parameters(&self, friction: f64) -> RtMoverParameters {
        RtMoverParameters {
            friction,
            payload: self.payload.as_ref().map(Payload::load),
            ..RtMoverParameters::nominal()
        }
    }
}

impl Section for RtMover {
    fn check(&self, conditions: &Conditions) -> Result<(), Problem> {
        if let Some(payload) = &self.payload {
            payload.check("robot.rt_mover.payload", conditions.duration_s)?;
        }
        if let Terrain::Stairs { .. } = conditions.terrain {
            return contradiction("terrain", "is stairs; RT-Mover's gait is for one step");
        }
        Ok(())
    }

    fn payload_mut(&mut self) -> Option<&mut Payload> {
        self.payload.as_mut()
    }

    fn front_m(&self) -> f64 {
        0.5 * BODY_LENGTH + WHEEL_RADIUS
    }

    fn posture(&self) -> Posture {
        Posture::Step
    }

    fn nodes(&self, conditions: &Conditions) -> Vec<NodeSpec> {
        nodes::nodes(self, conditions)
    }

    fn plant(&self, conditions: &Conditions) -> Box<dyn Plant> {
        let parameters = self.parameters(conditions.friction);
        let ground = conditions.terrain.ground();
        Box::new(plant::RtMover::new(&parameters, &ground, conditions.seed))
    }
}
