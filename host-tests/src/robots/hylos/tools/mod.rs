//! What the tools ask of Hylos.

mod evaluate;
mod operators;
mod urdf;

use super::section::Hylos;
use crate::scenario::Description;
use crate::tools::evaluate::Groups;
use crate::tools::generate::urdf as description;
use crate::tools::robot::Tools;
use crate::tools::suite::draw::generator::Random;
use tautrack::math::Scalar;

impl Tools for Hylos {
    fn operator(random: &mut Random) -> Description {
        operators::draw(random)
    }

    fn places() -> &'static [(&'static str, &'static str)] {
        &[
            ("hillside of 41°", "hylos/loop.toml"),
            ("slope", "hylos/hazards/quick-turn-uphill.toml"),
        ]
    }

    fn groups<S: Scalar>() -> Groups {
        evaluate::groups::<S>()
    }

    fn links() -> Option<description::Description> {
        Some(urdf::links())
    }
}
