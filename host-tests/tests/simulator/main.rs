//! Tests of the simulator: bus, nodes, runs and sessions.

mod boards_alike;
mod bus;
#[path = "../../../shared/tests/support/conformance/mod.rs"]
mod conformance;
mod live;
mod node_log;
#[path = "../../../shared/tests/support/parallel.rs"]
mod parallel;
mod programs;
mod runs;
mod session;
mod slcan;
#[path = "../support/unchanged.rs"]
mod unchanged;
