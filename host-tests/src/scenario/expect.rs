//! The results that a scenario expects of its run.

use serde::{Deserialize, Serialize};

/// The expected results; what is absent is not checked.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// Whether the guard arms the robot. If this is absent, it must arm the robot of a scenario
    /// that expects anything and has an operator of its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub armed: Option<bool>,
    /// Whether the robot stands level behind the last nose at some time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub landed: Option<bool>,
    /// Whether the robot turns over.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub toppled: Option<bool>,
    /// Earliest and latest virtual time of the landing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub landing_between_s: Option<[f64; 2]>,
    /// Whether the robot stands still during the last second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopped: Option<bool>,
    /// Whether the guard scales or refuses a command at least once.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub guard_intervenes: Option<bool>,
    /// Upper bound of the belt's strain or slack during the climb.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tension_error_below_m: Option<f64>,
}
