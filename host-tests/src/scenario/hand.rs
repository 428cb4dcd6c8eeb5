//! A hand that lifts, tilts and turns the robot.

use crate::bounds::{Problem, contradiction, within};
use crate::robots::Kind;
use crate::world::hand::{Held, Path};
use serde::{Deserialize, Serialize};

/// One motion of the hand: the posture to which it takes the robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Virtual time at which the motion begins.
    pub at_s: f64,
    /// Duration of the motion.
    pub within_s: f64,
    /// Height above the place at which the hand took hold of the robot.
    #[serde(default)]
    pub lift_m: f64,
    /// Pitch, nose up positive.
    #[serde(default)]
    pub pitch_deg: f64,
    /// Roll, left side up positive.
    #[serde(default)]
    pub roll_deg: f64,
    /// Heading, counter-clockwise from the x axis.
    #[serde(default)]
    pub turn_deg: f64,
}

/// Path of the hand through these postures.
pub(super) fn path(motions: &[Motion]) -> Path {
    let motion = |motion: &Motion| crate::world::hand::Motion {
        begin_s: motion.at_s,
        end_s: motion.at_s + motion.within_s,
        to: Held {
            height: motion.lift_m,
            pitch: motion.pitch_deg.to_radians(),
            roll: motion.roll_deg.to_radians(),
            heading: motion.turn_deg.to_radians(),
        },
    };
    Path::new(motions.iter().map(motion).collect())
}

/// Checks the bounds of the motions, their order, and that the robot's plant has a hand.
pub(super) fn check(motions: &[Motion], kind: Kind, duration_s: f64) -> Result<(), Problem> {
    if !motions.is_empty() && !kind.facts().has_hand {
        return contradiction("hand", "cannot hold this robot");
    }
    let mut free_s = 0.0;
    for (index, motion) in motions.iter().enumerate() {
        let check = |name, value, least, most, unit| {
            within(&format!("hand[{index}].{name}"), value, least, most, unit)
        };
        let before = "s (the motion before ends there)";
        check("at_s", motion.at_s, free_s, f64::MAX, before)?;
        let ends = "s (the run ends there)";
        check("at_s", motion.at_s, 0.0, duration_s, ends)?;
        check("within_s", motion.within_s, 0.1, 600.0, "s")?;
        check("lift_m", motion.lift_m, 0.0, 2.0, "m")?;
        check("pitch_deg", motion.pitch_deg, -60.0, 60.0, "deg")?;
        check("roll_deg", motion.roll_deg, -60.0, 60.0, "deg")?;
        check("turn_deg", motion.turn_deg, -3600.0, 3600.0, "deg")?;
        free_s = motion.at_s + motion.within_s;
    }
    Ok(())
}
