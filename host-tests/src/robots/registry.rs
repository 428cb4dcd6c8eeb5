//! The robots of the list in `tautrack::robots`, as values.

use super::NodeName;
use super::payload::Payload;
use super::section::{Facts, Section};
#[cfg(unix)]
use crate::programs::{self, Board, BuildError, Programs};
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

macro_rules! robots {
    ($($folder:ident::$name:ident: $about:literal,)*) => {
        /// Robot of a scenario.
        #[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
        pub enum Kind {
            $(#[doc = $about] $name,)*
        }

        impl Kind {
            /// Name of the robot's folder.
            pub fn folder(self) -> &'static str {
                match self {
                    $(Self::$name => stringify!($folder),)*
                }
            }

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
            $(#[doc = $about] $name(super::$folder::section::$name),)*
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

            /// Returns the load on the robot, if it has one.
            pub fn payload_mut(&mut self) -> Option<&mut Payload> {
                match self {
                    $(Self::$name(section) => section.payload_mut(),)*
                }
            }
        }
    };
}

tautrack::every_robot!(robots);

impl Kind {
    /// Name of the robot in a command line.
    pub fn argument(self) -> String {
        self.to_possible_value()
            .map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// Builds the robot's node programs; see [`programs::build`].
    ///
    /// # Errors
    /// Those of [`programs::build`].
    #[cfg(unix)]
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

impl Default for Kind {
    /// The robot of a scenario that names none.
    fn default() -> Self {
        Robot::default().kind()
    }
}
