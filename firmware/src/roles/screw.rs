//! `screw`.

use super::{Refusal, Role, Settings, dictionary, start_bus};
use embassy_executor::Spawner;

dictionary!(od, "screw.rs");

/// The role of this file.
pub static ROLE: Role = Role {
    name: "screw",
    start,
};

fn start(spawner: Spawner, settings: &Settings) -> Result<(), Refusal> {
    start_bus(spawner, settings, od::DICTIONARY, None, |_| {})
}
