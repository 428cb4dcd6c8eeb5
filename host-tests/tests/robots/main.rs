//! The simulated robots: plants against physics, controllers on plants, and whole runs.

mod b2p2_plant;
mod balance;
mod crawler;
mod hylos_plant;
#[allow(dead_code)] // joints are for the models in shared
#[path = "../../../shared/tests/support/random.rs"]
mod random;
mod rt_mover_step;
mod runs;
mod state;
