//! The robots: their masses, shapes and controllers.
//!
//! [`body`] is the interface that the guard requires of each; every robot has a folder of its own.
//! [`turn`] and [`odometry`] are shared parts.

pub mod b2p2;
pub mod body;
pub mod crawler;
pub mod hylos;
pub mod odometry;
pub mod rt_mover;
pub mod turn;

pub use body::{
    Ahead, Allowed, Body, Command, DriveState, Goal, MAX_DRIVES, MAX_OFFSETS, MAX_STAGES, Offset,
    Phase, PostureCommand, Stop,
};
