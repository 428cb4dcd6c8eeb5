//! Frame queues between the board and the node.

use super::queue::FrameQueue;

/// Frames that the board received; the node takes them.
pub static RECEIVED: FrameQueue<64> = FrameQueue::new();
/// Frames to send; the board takes them.
pub static TRANSMIT: FrameQueue<64> = FrameQueue::new();
