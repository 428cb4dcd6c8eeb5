//! Constants that all nodes share.

/// Rate of every node's control tick, Hz.
pub const CONTROL_HZ: u32 = 1_000;

/// Period of every node's control tick, s.
pub const CONTROL_PERIOD: f32 = 1.0 / CONTROL_HZ as f32;

/// Bandwidth of the observer of the shaft's velocity, rad/s.
pub const OBSERVER_BANDWIDTH: f32 = 600.0;

/// Acceleration of gravity, m/s^2: the value that the papers use. At sea level it is off by at most
/// 0.3 %.
pub const GRAVITY: f32 = GRAVITY_F64 as f32;

/// Acceleration of gravity in double precision, for the simulated physics and the papers' models.
pub const GRAVITY_F64: f64 = 9.81;
