//! Centre of gravity and zero moment point at one sample.

/// Positions at one sample: coordinates along z5, the level heading, from axle 1, m.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Axles 1 to 3: the paper's P1, P2 and P3.
    pub axles: [f64; 3],
    /// Centre of gravity.
    pub cog: f64,
    /// Zero moment point; absent in free flight.
    pub zmp: Option<f64>,
    /// Zero moment point minus centre of gravity, smoothed over [`super::SMOOTHING_S`].
    pub smoothed: Option<f64>,
}

impl Moment {
    /// Zero moment point minus centre of gravity, m.
    pub fn difference(&self) -> Option<f64> {
        self.zmp.map(|zmp| zmp - self.cog)
    }
}
