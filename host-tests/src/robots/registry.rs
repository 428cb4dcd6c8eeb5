//! The robots that there are: one line for each. A new one goes to the end, because the draws of
//! `cargo demo --suite operators` depend on the place of a robot.

use super::section::{Facts, Section};
use super::{NodeName, b2p2};
use crate::programs::{self, Board, BuildError, Programs};
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

macro_rules! robots {
    ($($(#[$about:meta])* $name:ident: $folder:ident,)*) => {
        /// Which robot.
        #[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
        pub enum Kind {
            $($(#[$about])* $name,)*
        }

        impl Kind {
            /// What is known of it without a scenario.
            pub fn facts(self) -> &'static Facts {
                match self {
                    $(Self::$name => &super::$folder::FACTS,)*
                }
            }
        }

        /// A robot's section of a scenario file, `[robot.NAME]`.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum Robot {
            $($(#[$about])* $name(super::$folder::section::$name),)*
        }

        impl Robot {
            /// Which robot it is.
            pub fn kind(&self) -> Kind {
                match self {
                    $(Self::$name(_) => Kind::$name,)*
                }
            }

            /// What it has to say to a run.
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
    /// Builds its node programs; see [`programs::build`].
    ///
    /// # Errors
    /// Of [`programs::build`].
    pub fn programs(self, board: Board) -> Result<Programs, BuildError> {
        programs::build(board, self.facts().guard_program)
    }
}

/// The node of any robot that has this name.
pub(super) fn node_name(text: &str) -> Option<NodeName> {
    let mut nodes = Kind::value_variants()
        .iter()
        .flat_map(|kind| kind.facts().nodes);
    nodes
        .find(|(name, _)| name.as_str() == text)
        .map(|(name, _)| *name)
}

impl Default for Robot {
    /// B2P2's nominal stand-in.
    fn default() -> Self {
        Self::B2p2(b2p2::section::B2p2::nominal())
    }
}

impl Robot {
    /// B2P2's section, if it is B2P2.
    pub fn b2p2(&self) -> Option<&b2p2::section::B2p2> {
        match self {
            Self::B2p2(section) => Some(section),
            _ => None,
        }
    }

    /// B2P2's section. Another robot is replaced by B2P2's nominal stand-in.
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
