//! Frame queues between the board and the tasks.

use super::queue::FrameQueue;
use core::sync::atomic::{AtomicU16, Ordering};
use tautrack::can::Frame;

/// Frames that the board received; the bus task takes them.
pub static RECEIVED: FrameQueue<64> = FrameQueue::new();
/// Frames to send; the board takes them.
pub static TRANSMIT: FrameQueue<64> = FrameQueue::new();

pub(super) const NMT: u16 = 0x000;
pub(super) const SYNC: u16 = 0x080;

/// NMT command that this node has sent and not followed yet; 0 if there is none.
static OWN_COMMAND: AtomicU16 = AtomicU16::new(0);

/// Sends `frame`.
pub fn send(frame: Frame) {
    TRANSMIT.push(frame);
}

/// Sends `frame` as the master of the network: SYNC and NMT commands apply to this node, too.
pub fn send_as_master(frame: Frame) {
    send(frame);
    if frame.id() == NMT {
        OWN_COMMAND.store(command(&frame), Ordering::Relaxed);
    }
    if matches!(frame.id(), NMT | SYNC) {
        RECEIVED.push(frame);
    }
}

/// Returns whether this node has sent the NMT command `frame` and has not followed it yet.
pub fn is_own_command(frame: &Frame) -> bool {
    let (command, order) = (command(frame), Ordering::Relaxed);
    let taken = OWN_COMMAND.compare_exchange(command, 0, order, order);
    command != 0 && taken.is_ok()
}

/// Returns an NMT command and the node that it addresses; 0 for a frame that has none.
fn command(frame: &Frame) -> u16 {
    match frame.data() {
        &[command, node] => u16::from_le_bytes([command, node]),
        _ => 0,
    }
}
