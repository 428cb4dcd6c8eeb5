//! Random states of B2P2.

/// A reproducible sequence of numbers from -1 to 1.
pub struct Random(pub u64);

impl Random {
    /// The next one.
    pub fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Eight of them, each times its scale.
    pub fn joints(&mut self, scale: [f64; 8]) -> [f64; 8] {
        scale.map(|scale| scale * self.next())
    }

    /// Joint positions, far beyond what the robot reaches.
    pub fn q(&mut self) -> [f64; 8] {
        self.joints([2.0, 2.0, 2.0, 3.1, 1.5, 1.5, 2.5, 0.3])
    }
}
