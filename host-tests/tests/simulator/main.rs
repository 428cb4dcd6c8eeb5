//! Tests of the simulator: bus, nodes, runs and sessions.

mod bus;
mod estimate;
mod node_log;
mod runs;
mod session;
mod slcan;
