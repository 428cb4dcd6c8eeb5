//! What must come out of a run.

use serde::{Deserialize, Serialize};

/// What must come out; what is absent is not asked.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// Stands level behind the last nose at some moment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub landed: Option<bool>,
    /// Turns over.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub toppled: Option<bool>,
    /// Earliest and latest landing, virtual time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub landing_between_s: Option<[f64; 2]>,
    /// Stands still during the last second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopped: Option<bool>,
    /// The guard holds back or refuses at least once.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub guard_intervenes: Option<bool>,
    /// Largest strain or slack of the belt during the climb.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tension_error_below_m: Option<f64>,
}
