//! What the tools ask of a robot.

use super::evaluate::Groups;
use super::generate::urdf;
use super::suite::draw::generator::Random;
use super::suite::draw::{self, Family};
use crate::robots;
use crate::robots::Kind;
use crate::scenario::Description;
use tautrack::math::Scalar;

/// What the tools ask of a robot, beside its section of a scenario file.
pub(crate) trait Tools {
    /// Draws ground, load and commands of a random operator.
    fn operator(random: &mut Random) -> Description;

    /// Returns the grounds that the page offers: name, and file in `host-tests/scenarios`.
    fn places() -> &'static [(&'static str, &'static str)] {
        &[]
    }

    /// Returns the functions of `cargo evaluate`, by groups.
    fn groups<S: Scalar>() -> Groups {
        Vec::new()
    }

    /// Returns joints and masses for the URDF file; `None` if the robot has no such file.
    fn links() -> Option<urdf::Description> {
        None
    }

    /// Returns the families of this kind in the hazard suite, which draws them for the default
    /// robot.
    fn families(_: draw::Kind) -> &'static [Family] {
        &[]
    }
}

macro_rules! tools {
    ($($folder:ident::$name:ident: $about:literal,)*) => {
        /// [`Tools::operator`] of a robot.
        pub(super) fn operator(robot: Kind, random: &mut Random) -> Description {
            match robot {
                $(Kind::$name => <robots::$folder::section::$name as Tools>::operator(random),)*
            }
        }

        /// [`Tools::places`] of a robot.
        pub(super) fn places(robot: Kind) -> &'static [(&'static str, &'static str)] {
            match robot {
                $(Kind::$name => <robots::$folder::section::$name as Tools>::places(),)*
            }
        }

        /// [`Tools::groups`] of all robots.
        pub(super) fn groups<S: Scalar>() -> Groups {
            let mut all = Groups::new();
            $(all.extend(<robots::$folder::section::$name as Tools>::groups::<S>());)*
            all
        }

        /// [`Tools::links`] of a robot.
        pub(super) fn links(robot: Kind) -> Option<urdf::Description> {
            match robot {
                $(Kind::$name => <robots::$folder::section::$name as Tools>::links(),)*
            }
        }

        /// [`Tools::families`] of a robot.
        pub(super) fn families(robot: Kind, kind: draw::Kind) -> &'static [Family] {
            match robot {
                $(Kind::$name => <robots::$folder::section::$name as Tools>::families(kind),)*
            }
        }
    };
}

tautrack::every_robot!(tools);
