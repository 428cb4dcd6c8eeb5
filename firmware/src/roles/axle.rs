//! Role `axle`: the node of one motor that follows the set-points from the bus.

use super::{Role, Spawners, drive};
use crate::check;
use crate::refusal::{Refusal, refuse};
use static_cell::StaticCell;
use tautrack::node::axle::Axle;
use tautrack::roles::axle::TABLE;
use tautrack::roles::settings::Found;
use tautrack::settings::Settings;

/// The role `axle`.
pub static ROLE: Role = Role {
    name: "axle",
    table: &TABLE,
    shaft_sensor: true,
    check: check::axle,
    start,
};

fn start(spawners: Spawners, settings: &Settings, found: Found) -> Result<(), Refusal> {
    static NODE: StaticCell<drive::Drive<Axle>> = StaticCell::new();
    drive::install_current_loop(settings)?;
    let parts = drive::parts(&ROLE, settings, found, create(settings)?)?;
    let node = NODE.try_init_with(|| drive::Drive::axle(parts));
    super::spawn(spawners, node.ok_or_else(twice)?)
}

fn twice() -> Refusal {
    refuse("axle", "it was started before")
}

/// Creates the axle in a static variable: so it is not copied through the stack.
fn create(settings: &Settings) -> Result<&'static mut Axle, Refusal> {
    static AXLE: StaticCell<Axle> = StaticCell::new();
    AXLE.try_init_with(|| Axle::new(settings)).ok_or_else(twice)
}
