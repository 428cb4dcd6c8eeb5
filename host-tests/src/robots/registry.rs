//! List of the robots, with one line for each. A new robot goes to the end, because the random
//! operators of `cargo demo --suite operators` depend on a robot's position in the list.

use super::section::{Facts, Section};
use super::{NodeName, b2p2};
use crate::programs::{self, Board, BuildError, Programs};
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

macro_rules! robots {
    ($($(#[$about:meta])* $name:ident: $folder:ident,)*) => {
        /// Robot of a scenario.
        #[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
        pub enum Kind {
            $($(#[$about])* $name,)*
        }

        impl Kind {
            /// Facts about the robot that do not depend on a scenario.
            pub fn facts(self) -> &'static Facts {
                match self {
                    $(Self::$name => &super::$folder::FACTS,)*
                }
            }
        }

        /// Robot's section of a scenario file, `[robot.NAME]`.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum Robot {
            $($(#[$about])* $name(super::$folder::section::$name),)*
        }

        impl Robot {
            /// Returns which robot it is.
            pub fn kind(&self) -> Kind {
                match self {
                    $(Self::$name(_) => Kind::$name,)*
                }
            }

            /// Returns the section of the robot.
            pub fn section(&self) -> &dyn Section {
                match self {
                    $(Self::$name(section) => section,)*
                }
            }
        }
    };
}

robots! {
    /// Tracked, variable geometry (Paillat et al.)
    B2p2: b2p2,
    /// Two tracks on soft ground (Kurc and Szybicki)
    Crawler: crawler,
    /// Four legs with steered wheels (Besseron et al.)
    Hylos: hylos,
    /// Four wheels on two arms that step (Nakajima)
    RtMover: rt_mover,
}

impl Kind {
    /// Builds the robot's node programs; see [`programs::build`].
    ///
    /// # Errors
    /// Those of [`programs::build`].
    pub fn programs(self, board: Board) -> Result<Programs, BuildError> {
        programs::build(board, self.facts().guard_program)
    }
}

/// Returns the node with this name, of any robot.
pub(super) fn node_name(text: &str) -> Option<NodeName> {
    let mut nodes = Kind::value_variants()
        .iter()
        .flat_map(|kind| kind.facts().nodes);
    nodes
        .find(|(name, _)| name.as_str() == text)
        .map(|(name, _)| *name)
}

impl Default for Robot {
    /// B2P2 with its nominal values.
    fn default() -> Self {
        Self::B2p2(b2p2::section::B2p2::nominal())
    }
}

impl Robot {
    /// Returns B2P2's section; `None` for another robot.
    pub fn b2p2(&self) -> Option<&b2p2::section::B2p2> {
        match self {
            Self::B2p2(section) => Some(section),
            _ => None,
        }
    }

    /// Returns B2P2's section. Replaces another robot with B2P2 and its nominal values.
    pub fn b2p2_mut(&mut self) -> &mut b2p2::section::B2p2 {
        if self.b2p2().is_none() {
            *self = Self::default();
        }
        match self {
            Self::B2p2(section) => section,
            _ => unreachable!("it was replaced"),
        }
    }
}
