//! Role `screw`: the node of the driving screw, an axle that follows the chassis joint. It receives
//! the joint's motion directly from the joint's node, without the guard.

use super::{Role, Spawners, drive};
use crate::check;
use crate::refusal::{Refusal, refuse};
use static_cell::{ConstStaticCell, StaticCell};
use tautrack::node::screw;
use tautrack::roles::screw::TABLE;
use tautrack::roles::settings::Found;
use tautrack::screw::Geometry;
use tautrack::settings::Settings;

/// The role `screw`.
pub static ROLE: Role = Role {
    name: "screw",
    table: &TABLE,
    shaft_sensor: false,
    check: check::screw,
    start,
};

fn start(spawners: Spawners, settings: &Settings, found: Found) -> Result<(), Refusal> {
    static NODE: StaticCell<drive::Drive<Screw>> = StaticCell::new();
    let screw = create(settings, create_geometry(settings)?)?;
    drive::install_current_loop(settings)?;
    let parts = drive::parts(&ROLE, settings, found, screw)?;
    let node = NODE.try_init_with(|| drive::Drive::screw(parts));
    super::spawn(spawners, node.ok_or_else(twice)?)
}

fn twice() -> Refusal {
    refuse("screw", "it was started before")
}

/// A screw whose geometry, with a large table, is in a static variable.
type Screw = screw::Screw<&'static Geometry>;

/// Creates the geometry in a static variable: so it is not copied through the stack.
fn create_geometry(settings: &Settings) -> Result<&'static Geometry, Refusal> {
    static GEOMETRY: ConstStaticCell<Option<Geometry>> = ConstStaticCell::new(None);
    let place = GEOMETRY.try_take().ok_or_else(twice)?;
    screw::geometry_in(place, settings)
        .map_err(|error| refuse("geometry", format_args!("{error:?}")))
}

/// Creates the screw in a static variable: so it is not copied through the stack.
#[inline(never)]
fn create(settings: &Settings, geometry: &'static Geometry) -> Result<&'static mut Screw, Refusal> {
    static SCREW: StaticCell<Screw> = StaticCell::new();
    SCREW
        .try_init_with(|| Screw::with_geometry(settings, geometry))
        .ok_or_else(twice)
}
