//! Names of nodes.

use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;
use std::fmt;

/// Name of a node. A name is valid if the node table of a robot contains it; each robot has a
/// guard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(transparent)]
pub struct NodeName(&'static str);

impl NodeName {
    /// Node of the guard.
    pub const GUARD: Self = Self("guard");
    /// Node of the left track.
    pub const LEFT_TRACK: Self = Self("left_track");
    /// Node of the right track.
    pub const RIGHT_TRACK: Self = Self("right_track");
    /// Node of the front left wheel.
    pub const FRONT_LEFT_WHEEL: Self = Self("front_left_wheel");
    /// Node of the front right wheel.
    pub const FRONT_RIGHT_WHEEL: Self = Self("front_right_wheel");
    /// Node of the rear left wheel.
    pub const REAR_LEFT_WHEEL: Self = Self("rear_left_wheel");
    /// Node of the rear right wheel.
    pub const REAR_RIGHT_WHEEL: Self = Self("rear_right_wheel");

    /// Creates a name, spelled as in a scenario file.
    pub const fn new(name: &'static str) -> Self {
        Self(name)
    }

    /// The name as spelled in a scenario file.
    pub fn as_str(self) -> &'static str {
        self.0
    }
}

impl fmt::Display for NodeName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

impl<'de> Deserialize<'de> for NodeName {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let text = Cow::<str>::deserialize(from)?;
        super::registry::node_name(&text)
            .ok_or_else(|| serde::de::Error::custom(format_args!("no robot has a node `{text}`")))
    }
}
