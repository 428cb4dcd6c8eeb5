//! A bounded queue of frames that both tasks and interrupts may use.

use core::sync::atomic::{AtomicU32, Ordering};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use tautrack::can::Frame;

/// Frames, oldest first. What comes while it is full is dropped and counted: on a bus the newest is sent again.
pub struct FrameQueue<const N: usize> {
    frames: Channel<CriticalSectionRawMutex, Frame, N>,
    dropped: AtomicU32,
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
            dropped: AtomicU32::new(0),
        }
    }

    /// Appends `frame`, or drops it.
    pub fn push(&self, frame: Frame) {
        if self.frames.try_send(frame).is_err() {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// The oldest frame.
    pub fn pop(&self) -> Option<Frame> {
        self.frames.try_receive().ok()
    }

    /// Waits for the oldest frame.
    pub async fn next(&self) -> Frame {
        self.frames.receive().await
    }

    /// Frames dropped since power-up; wraps.
    pub fn dropped(&self) -> u32 {
        self.dropped.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_queue_keeps_the_oldest_and_counts_the_rest() {
        let queue = FrameQueue::<2>::new();
        for id in 1..=5 {
            queue.push(Frame::new(id, &[]).unwrap());
        }
        assert_eq!(queue.dropped(), 3);
        assert_eq!(queue.pop().unwrap().id(), 1);
        assert_eq!(queue.pop().unwrap().id(), 2);
        assert_eq!(queue.pop(), None);
    }
}
