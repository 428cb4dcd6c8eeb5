//! `cargo tool settings`: reads and writes the settings of the nodes on a bus.
//!
//! `arguments` is the command line. `adapter` is the connection to an SLCAN adapter, `client` the
//! CANopen client: SDO, heartbeats and LSS. `backup` is the file with the settings of all nodes.
//! `command` does the work.

mod adapter;
mod arguments;
mod backup;
mod client;
mod command;
mod error;

pub(super) use arguments::Command;
pub(super) use backup::Backup;
pub(super) use command::run;
