//! The robots: masses, shapes and what their bodies do.

pub mod b2p2;
pub mod rt_mover;
