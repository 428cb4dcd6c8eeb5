//! The virtual CAN bus: classic CAN at 1 Mbit/s between the nodes of a lockstep run, not a queue.
//!
//! [`wire`]: how long a frame occupies the bus. [`arbitration`]: who sends when. [`figures`]: load and latency of a run.
//! [`disturbance`]: what can be done to it. Not modelled: error frames, retransmission, bus-off; a disturbed frame is
//! gone or wrong for every listener alike.

pub mod arbitration;
pub mod disturbance;
pub mod figures;
pub mod wire;

pub use arbitration::{Bus, Collision, Delivered, Overflow};
pub use figures::Figures;
