//! Hylos' functions for `cargo evaluate`, one file for each group.

mod control;
mod margin;
mod parameters;

use crate::tools::evaluate::Groups;
use tautrack::math::Scalar;

pub fn groups<S: Scalar>() -> Groups {
    vec![
        ("hylos_margin", margin::functions::<S>()),
        ("hylos_control", control::functions::<S>()),
    ]
}
