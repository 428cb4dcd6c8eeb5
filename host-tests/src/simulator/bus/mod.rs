//! Virtual CAN bus between the nodes of a lockstep run. It simulates classic CAN at 1 Mbit/s, with
//! arbitration and transmission times.
//!
//! [`wire`]: the time that a frame takes on the bus. [`arbitration`]: the order of the frames.
//! [`figures`]: load and latency of a run. [`disturbance`]: faults of the bus. Error frames,
//! retransmission and bus-off are not modelled; a disturbed frame is lost or wrong for all
//! receivers.

pub mod arbitration;
pub mod disturbance;
pub mod figures;
pub mod wire;

pub use arbitration::{Bus, Collision, Delivered, Overflow};
pub use figures::Figures;
