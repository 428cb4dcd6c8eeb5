//! B2P2's families of the hazard suite.

mod family;
mod hazards;
mod legitimate;
mod manoeuvres;

pub use family::mass;

use crate::tools::suite::draw::{Family, Kind};

/// Returns the families of this kind.
pub fn families(kind: Kind) -> &'static [Family] {
    match kind {
        Kind::Hazard => hazards::FAMILIES,
        Kind::Legitimate => legitimate::FAMILIES,
    }
}
