//! B2P2's functions for `cargo evaluate`, one file for each group.

mod clearance;
mod dynamics;
mod fk_com;
mod parameters;
mod screw;
mod zmp;

use crate::tools::evaluate::Groups;
use tautrack::math::Scalar;

pub fn groups<S: Scalar>() -> Groups {
    vec![
        ("b2p2_screw", screw::functions::<S>()),
        ("b2p2_fk_com", fk_com::functions::<S>()),
        ("b2p2_dynamics", dynamics::functions::<S>()),
        ("b2p2_clearance", clearance::functions::<S>()),
        ("b2p2_zmp", zmp::functions::<S>()),
    ]
}
