//! How near a robot is to falling over, and what that leaves of a command: how it stands ([`attitude`]), how far its
//! centre of gravity is from each edge of its support ([`support`]), what passes ([`filter`]).

pub mod attitude;
pub mod filter;
pub mod support;
