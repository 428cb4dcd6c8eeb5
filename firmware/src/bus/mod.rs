//! A node's interface to the CANopen bus.
//!
//! `queue` implements a frame queue and `traffic` holds the queues between board and tasks.
//! `filter` refuses what a client may not request. `stack` is the node: network management, process
//! data, heartbeat; `sdo` serves the objects of the dictionary. `object` makes objects of the rows
//! of a table. `parameters` serves the objects of the settings. `configuration` describes the
//! node's bus settings; `service` is the bus task, and `unconfigured` that of a node without an id.

mod configuration;
mod filter;
pub mod object;
mod parameters;
mod queue;
#[allow(clippy::trivially_copy_pass_by_ref)] // a pointer is smaller than the eight bytes
mod sdo;
mod service;
mod stack;
mod traffic;
mod unconfigured;

pub use configuration::{Dictionary, Listen, Master};
pub use filter::is_capture;
pub use queue::FrameQueue;
pub use service::task;
pub use stack::{Bus, Received, Written, operational};
pub use traffic::{RECEIVED, TRANSMIT, is_own_command, send, send_as_master};
pub use unconfigured::wait_for_id;
