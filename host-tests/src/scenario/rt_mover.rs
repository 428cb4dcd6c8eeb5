//! RT-Mover in a scenario: what differs from the robot of the library, and its bounds.

use super::check::contradiction;
use super::{Description, Payload, Problem, Robot, Terrain};
use crate::plant::rt_mover::RtMoverParameters;
use serde::{Deserialize, Serialize};

/// The leg-wheel robot; `[rt_mover]` alone is the robot as the library has it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RtMover {
    /// Load on the seat; its place is from the body's middle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub payload: Option<Payload>,
}

impl RtMover {
    pub(super) fn check(&self, scenario: &Description) -> Result<(), Problem> {
        if scenario.robot != Robot::nominal() {
            return contradiction("robot", "is B2P2, but there is an [rt_mover] as well");
        }
        if scenario.crawler.is_some() {
            return contradiction("rt_mover", "is one robot, [crawler] another");
        }
        if let Some(payload) = &self.payload {
            payload.check("rt_mover.payload", scenario.duration_s)?;
        }
        if let Terrain::Stairs { .. } = scenario.terrain {
            return contradiction("terrain", "is stairs; RT-Mover's gait is for one step");
        }
        Ok(())
    }

    /// The robot as the plant takes it, on ground of this friction.
    pub fn parameters(&self, friction: f64) -> RtMoverParameters {
        RtMoverParameters {
            friction,
            payload: self.payload.as_ref().map(Payload::plant),
            ..RtMoverParameters::nominal()
        }
    }
}
