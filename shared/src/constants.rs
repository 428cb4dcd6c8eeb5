//! Numbers that every node shares.

/// Period of every node's control tick, s.
pub const CONTROL_PERIOD: f32 = 1e-3;

/// Acceleration of gravity, m/s^2: the papers' figure. On Earth's surface it is off by at most 0.3 %.
pub const GRAVITY: f32 = GRAVITY_F64 as f32;

/// The same for simulated physics and for the papers' models.
pub const GRAVITY_F64: f64 = 9.81;
