//! A node's interface to the CANopen bus.
//!
//! `queue` implements a frame queue and `traffic` holds the queues between board and tasks.
//! `filter` keeps frames from the stack that it handles wrongly. `stack` contains the CANopen
//! stack, and sends the heartbeat and boot-up messages, which the stack does not send as CiA 301
//! requires. `configuration` describes the node's bus settings; `service` is the bus task. Node ids
//! and settings come from the board's store, so storing and restoring parameters (objects 0x1010
//! and 0x1011) and LSS are not supported.

mod configuration;
mod filter;
mod queue;
mod service;
mod stack;
mod traffic;

pub use configuration::{Dictionary, Listen, Master};
pub use filter::is_capture;
pub use queue::FrameQueue;
pub use service::task;
pub use stack::{Bus, Received, operational};
pub use traffic::{RECEIVED, TRANSMIT, send};
