//! Tests of the simulated robots: plants against physics, controllers on plants, and whole runs.

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
