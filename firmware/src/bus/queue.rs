//! Bounded queue of frames, usable in tasks and interrupts.

use core::sync::atomic::{AtomicBool, Ordering};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use tautrack::can::Frame;

/// Queue of frames, oldest first. While it is full, new frames are lost, which it remembers;
/// CANopen nodes repeat their current values.
pub struct FrameQueue<const N: usize> {
    frames: Channel<CriticalSectionRawMutex, Frame, N>,
    lost: AtomicBool,
}

impl<const N: usize> Default for FrameQueue<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> FrameQueue<N> {
    /// An empty queue.
    pub const fn new() -> Self {
        Self {
            frames: Channel::new(),
            lost: AtomicBool::new(false),
        }
    }

    /// Appends `frame`, which is lost if the queue is full.
    pub fn push(&self, frame: Frame) {
        if self.frames.try_send(frame).is_err() {
            self.lost.store(true, Ordering::Relaxed);
        }
    }

    /// Removes and returns the oldest frame.
    pub fn pop(&self) -> Option<Frame> {
        self.frames.try_receive().ok()
    }

    /// Waits for a frame; removes and returns the oldest one.
    pub async fn next(&self) -> Frame {
        self.frames.receive().await
    }

    /// Returns whether a frame was lost since the last call.
    pub fn take_lost(&self) -> bool {
        self.lost.swap(false, Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_queue_keeps_the_oldest_and_says_once_that_it_has_lost_the_rest() {
        let queue = FrameQueue::<2>::new();
        for id in 1..=5 {
            assert!(!queue.take_lost() || id > 3, "{id}");
            queue.push(Frame::new(id, &[]).unwrap());
        }
        assert!(queue.take_lost() && !queue.take_lost());
        assert_eq!(queue.pop().unwrap().id(), 1);
        assert_eq!(queue.pop().unwrap().id(), 2);
        assert_eq!(queue.pop(), None);
    }
}
