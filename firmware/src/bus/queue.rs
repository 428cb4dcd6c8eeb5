//! Bounded queue of frames, usable in tasks and interrupts.

use core::sync::atomic::{AtomicU32, Ordering};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use tautrack::can::Frame;

/// Queue of frames, oldest first. While it is full, new frames are dropped and counted; CANopen
/// nodes repeat their current values.
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

    /// Appends `frame`; drops it if the queue is full.
    pub fn push(&self, frame: Frame) {
        if self.frames.try_send(frame).is_err() {
            self.dropped.fetch_add(1, Ordering::Relaxed);
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
