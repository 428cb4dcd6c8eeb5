//! Frame queues between the board and the tasks.

use super::queue::FrameQueue;
use tautrack::can::Frame;

/// Frames that the board received; the bus task takes them.
pub static RECEIVED: FrameQueue<64> = FrameQueue::new();
/// Frames to send; the board takes them.
pub static TRANSMIT: FrameQueue<64> = FrameQueue::new();

pub(super) const NMT: u16 = 0x000;
pub(super) const SYNC: u16 = 0x080;

/// Sends `frame`. SYNC and NMT commands are also put into [`RECEIVED`], because they apply to the
/// sending node too.
pub fn send(frame: Frame) {
    TRANSMIT.push(frame);
    if matches!(frame.id(), NMT | SYNC) {
        RECEIVED.push(frame);
    }
}
