//! The node's end of the CANopen bus.
//!
//! `queue` holds frames, `traffic` is those between board and tasks, `filter` keeps from the stack
//! what it cannot take, and `stack` is the stack itself with the heartbeat and boot-up messages
//! that it does not send as CiA 301 asks. `configuration` says what a node is told, `service` is
//! the task. Node ids and settings come from the board's store: 0x1010, 0x1011 and LSS are not
//! offered.

mod configuration;
mod filter;
mod queue;
mod service;
mod stack;
mod traffic;

pub use configuration::{Dictionary, Listen, Master};
pub use queue::FrameQueue;
pub use service::task;
pub use stack::{Bus, Received, operational};
pub use traffic::{RECEIVED, TRANSMIT, send};
