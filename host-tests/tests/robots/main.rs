//! Tests of the simulated robots: plants against physics, controllers on plants, and whole runs.

mod b2p2_belt;
mod b2p2_plant;
mod balance;
mod crawler;
mod hylos_plant;
#[allow(dead_code)] // the models in shared need the joints
#[path = "../../../shared/tests/support/random.rs"]
mod random;
mod rt_mover_step;
mod runs;
mod state;
#[path = "../support/unchanged.rs"]
#[allow(dead_code)] // other tests name their programs themselves
mod unchanged;

/// Stamp of a test whose input is this executable alone, see [`unchanged::stamp_of_programs`].
fn stamp(test: &str) -> Option<unchanged::Stamp> {
    unchanged::stamp_of_programs(&format!("robots-{test}"), [])
}
