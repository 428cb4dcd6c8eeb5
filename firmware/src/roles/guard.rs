//! `guard`.

use super::{Refusal, Role, dictionary, start_bus};
use embassy_executor::Spawner;
use tautrack::settings::Settings;

dictionary!(od, "guard.rs");

/// The role of this file.
pub static ROLE: Role = Role {
    name: "guard",
    start,
};

fn start(spawner: Spawner, settings: &Settings) -> Result<(), Refusal> {
    start_bus(spawner, settings, od::DICTIONARY, None, |_| {})
}
