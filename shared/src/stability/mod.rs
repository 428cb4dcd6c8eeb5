//! How near to falling over a robot is, and what that leaves of a command.
//!
//! How it stands ([`attitude`]) and how far that is to be believed ([`trust`]); how far its centre of gravity is from each edge of
//! its support ([`support`]), and which margin counts ([`criterion`]); the band that this is ([`bands`]), what passes ([`filter`]) within
//! which limits ([`limits`]), and the latch behind it ([`trip`]); the numbers of all these ([`parameters`]). For any
//! scalar, where the ground's reaction acts ([`zmp`]) and how far the forces are from tipping the robot over an edge ([`tipover`]).

pub mod attitude;
pub mod bands;
pub mod criterion;
pub mod filter;
pub mod limits;
pub mod parameters;
pub mod support;
pub mod tipover;
pub mod trip;
pub mod trust;
pub mod zmp;
