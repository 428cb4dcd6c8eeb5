//! What the tools ask of B2P2.

mod evaluate;
mod operators;
mod suite;
mod urdf;

use super::section::B2p2;
use crate::scenario::Description;
use crate::tools::evaluate::Groups;
use crate::tools::generate::urdf as description;
use crate::tools::robot::Tools;
use crate::tools::suite::draw::generator::Random;
use crate::tools::suite::draw::{Family, Kind};
use tautrack::math::Scalar;

impl Tools for B2p2 {
    fn operator(random: &mut Random) -> Description {
        operators::draw(random)
    }

    fn groups<S: Scalar>() -> Groups {
        evaluate::groups::<S>()
    }

    fn links() -> Option<description::Description> {
        Some(urdf::links())
    }

    fn families(kind: Kind) -> &'static [Family] {
        suite::families(kind)
    }
}
