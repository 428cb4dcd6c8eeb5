//! Numbers that every node shares.

/// Period of every node's control tick, s.
pub const CONTROL_PERIOD: f32 = 1e-3;

/// Standard gravity, m/s^2.
pub const GRAVITY: f32 = 9.80665;
