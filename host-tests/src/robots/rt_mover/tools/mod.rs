//! What the tools ask of RT-Mover.

mod evaluate;
mod operators;
mod urdf;

use super::section::RtMover;
use crate::scenario::Description;
use crate::tools::evaluate::Groups;
use crate::tools::generate::urdf as description;
use crate::tools::robot::Tools;
use crate::tools::suite::draw::generator::Random;
use tautrack::math::Scalar;

impl Tools for RtMover {
    fn operator(random: &mut Random) -> Description {
        operators::draw(random)
    }

    fn places() -> &'static [(&'static str, &'static str)] {
        &[
            ("step of 10 cm", "rt-mover/step-10.toml"),
            ("step of 15 cm", "rt-mover/step-15.toml"),
            ("step of 20 cm", "rt-mover/step-20.toml"),
        ]
    }

    fn groups<S: Scalar>() -> Groups {
        vec![("rt_mover", evaluate::functions::<S>())]
    }

    fn links() -> Option<description::Description> {
        Some(urdf::links())
    }
}
