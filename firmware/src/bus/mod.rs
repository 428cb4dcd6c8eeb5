//! Frames between the board and the node, and the bus of a node without an id.
//!
//! `queue` implements a frame queue, and `traffic` holds the queues. `unconfigured` is the task of
//! a node without an id.

mod queue;
mod traffic;
#[cfg(target_os = "none")]
mod unconfigured;

pub use queue::FrameQueue;
pub use traffic::{RECEIVED, TRANSMIT, condition};
#[cfg(target_os = "none")]
pub use unconfigured::wait_for_id;
