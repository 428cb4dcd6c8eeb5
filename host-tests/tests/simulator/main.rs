//! Tests of the simulator: bus, nodes, runs and sessions.

mod bus;
mod node_log;
mod programs;
mod runs;
mod session;
mod shared_machine;
mod slcan;
#[path = "../support/unchanged.rs"]
mod unchanged;
