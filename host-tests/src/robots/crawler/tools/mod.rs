//! What the tools ask of the crawler.

mod evaluate;
mod operators;
mod urdf;

use super::section::Crawler;
use crate::scenario::Description;
use crate::tools::evaluate::Groups;
use crate::tools::generate::urdf as description;
use crate::tools::robot::Tools;
use crate::tools::suite::draw::generator::Random;
use tautrack::math::Scalar;

impl Tools for Crawler {
    fn operator(random: &mut Random) -> Description {
        operators::draw(random)
    }

    fn places() -> &'static [(&'static str, &'static str)] {
        &[
            ("level ground", "crawler/arc.toml"),
            ("slope of 20°", "crawler/slope.toml"),
            ("slope of 20°, weak soil", "crawler/slope-weak-soil.toml"),
        ]
    }

    fn groups<S: Scalar>() -> Groups {
        vec![("crawler", evaluate::functions::<S>())]
    }

    fn links() -> Option<description::Description> {
        Some(urdf::links())
    }
}
