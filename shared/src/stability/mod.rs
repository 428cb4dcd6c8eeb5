//! How near a robot is to falling over, and what that leaves of a command: how it stands ([`attitude`]), how far its
//! centre of gravity is from each edge of its support ([`support`]), what passes ([`filter`]); for any scalar, where the ground's
//! reaction acts ([`zmp`]) and how far the forces are from tipping it over an edge ([`tipover`]).

pub mod attitude;
pub mod filter;
pub mod support;
pub mod tipover;
pub mod zmp;
