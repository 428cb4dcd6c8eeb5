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

    fn places() -> &'static [(&'static str, &'static str)] {
        &[
            ("stairs", "staircase.toml"),
            ("level ground", "flat.toml"),
            ("curb of 20 cm", "hazards/curb-20-cm-front-up.toml"),
            ("curb of 30 cm, long belts", "curb-30-cm-released.toml"),
            ("stairs down", "legitimate/descent.toml"),
            ("ramp of 25°", "legitimate/ramp-25.toml"),
            ("slope across, 20°", "legitimate/side-slope-20.toml"),
        ]
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
