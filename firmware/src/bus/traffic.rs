//! Frames on their way between the board and the tasks.

use super::queue::FrameQueue;
use tautrack::can::Frame;

/// Frames that the board received, on their way to the bus task.
pub static RECEIVED: FrameQueue<64> = FrameQueue::new();
/// Frames on their way to the board.
pub static TRANSMIT: FrameQueue<64> = FrameQueue::new();

const NMT: u16 = 0x000;
pub(super) const SYNC: u16 = 0x080;

/// Sends `frame`. What a node tells all nodes it also tells itself: SYNC and NMT commands of its
/// own.
pub fn send(frame: Frame) {
    TRANSMIT.push(frame);
    if matches!(frame.id(), NMT | SYNC) {
        RECEIVED.push(frame);
    }
}
