//! What the results ask of a robot.

use super::report::OwnPage;
use super::zmp::OwnBalance;
use crate::robots::{self, Robot};

/// What a robot adds to the results of its runs. A robot that adds nothing is drawn from the sketch
/// and the channels of its plant.
pub(crate) trait Results {
    /// Returns its computation of the zero moment point on ground with this friction.
    fn balance(&self, _friction: f64) -> Option<OwnBalance> {
        None
    }

    /// Returns its parts of the page about a run on ground with this friction.
    fn page(&self, _friction: f64) -> Option<OwnPage> {
        None
    }
}

macro_rules! results {
    ($($folder:ident::$name:ident: $about:literal,)*) => {
        $(use robots::$folder::section::$name;)*

        /// [`Results::balance`] of a robot.
        pub(super) fn balance(robot: &Robot, friction: f64) -> Option<OwnBalance> {
            match robot {
                $(Robot::$name(section) => <$name as Results>::balance(section, friction),)*
            }
        }

        /// [`Results::page`] of a robot.
        pub(super) fn page(robot: &Robot, friction: f64) -> Option<OwnPage> {
            match robot {
                $(Robot::$name(section) => <$name as Results>::page(section, friction),)*
            }
        }
    };
}

tautrack::every_robot!(results);
