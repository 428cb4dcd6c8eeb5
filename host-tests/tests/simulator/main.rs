//! The simulator: bus, nodes and runs.

mod bus;
mod estimate;
mod node_log;
mod runs;
mod session;
mod slcan;
