//! Payload on a robot.

/// Compact load that is fixed to the robot's body from some time on.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Load {
    /// Mass, kg.
    pub mass: f64,
    /// Place in the body's axes: forward, left, up, m.
    pub place: [f64; 3],
    /// Time at which it is put on the robot, s.
    pub from_time_s: f64,
}

impl Load {
    /// Inertia about its own centre, kg m^2: that of a ball of 3 cm radius.
    pub fn own_inertia(&self) -> f64 {
        0.4 * self.mass * 0.03 * 0.03
    }
}
