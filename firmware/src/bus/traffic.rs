//! Frame queues between the board and the node.

use super::queue::FrameQueue;
use tautrack::bus::node::Condition;

/// Frames that the board received; the node takes them.
pub static RECEIVED: FrameQueue<64> = FrameQueue::new();
/// Frames to send; the board takes them.
pub static TRANSMIT: FrameQueue<64> = FrameQueue::new();

/// Condition of the bus since the last call: that of the controller, and of the queue behind it.
pub fn condition(controller: Condition) -> Condition {
    Condition {
        overrun: RECEIVED.take_lost() | controller.overrun,
        ..controller
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tautrack::can::Frame;

    #[test]
    fn a_frame_is_lost_in_the_controller_or_in_the_queue_behind_it() {
        let good = Condition::default();
        let overrun = Condition {
            overrun: true,
            ..good
        };
        assert_eq!(condition(good), good);
        assert_eq!(condition(overrun), overrun);
        let frame = Frame::new(0x080, &[]).unwrap();
        (0..64).for_each(|_| RECEIVED.push(frame));
        assert_eq!(condition(good), good);
        RECEIVED.push(frame);
        assert_eq!(condition(good), overrun);
        assert_eq!(condition(good), good);
    }
}
