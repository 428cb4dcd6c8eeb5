//! Names of nodes.

use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;
use std::fmt;

/// Name of a node. The table of a robot's nodes has its names; each robot has a guard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(transparent)]
pub struct NodeName(&'static str);

impl NodeName {
    /// The guard.
    pub const GUARD: Self = Self("guard");
    /// Left track.
    pub const LEFT_TRACK: Self = Self("left_track");
    /// Right track.
    pub const RIGHT_TRACK: Self = Self("right_track");
    /// Front left wheel.
    pub const FRONT_LEFT_WHEEL: Self = Self("front_left_wheel");
    /// Front right wheel.
    pub const FRONT_RIGHT_WHEEL: Self = Self("front_right_wheel");
    /// Rear left wheel.
    pub const REAR_LEFT_WHEEL: Self = Self("rear_left_wheel");
    /// Rear right wheel.
    pub const REAR_RIGHT_WHEEL: Self = Self("rear_right_wheel");

    /// The node of this name, as written in a scenario file.
    pub const fn new(name: &'static str) -> Self {
        Self(name)
    }

    /// As written in a scenario file.
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
