//! Slip of the crawler's tracks, computed from the speeds of belts and body.

use super::Crawler;
use super::track::CELLS;
use rapier3d_f64::math::Vector;

/// Belt speed below which the slip is set to 0, m/s.
const SLOWEST: f64 = 0.01;

impl Crawler {
    /// Speed of the middle between the belts' ground runs along the robot's forward axis, m/s, as a
    /// sensor under the belly would measure it.
    pub fn speed_over_ground(&self) -> f64 {
        let middle = self.body.place(Vector::ZERO);
        let forward = self.body.rotation * Vector::X;
        self.body.velocity_at(middle).dot(forward)
    }

    /// Slip of the left and right track from speeds, `1 - v / (r alpha)`; 0 for a belt slower than
    /// 10 mm/s.
    pub fn slip(&self) -> [f64; 2] {
        let forward = self.body.rotation * Vector::X;
        [0, 1].map(|side: usize| {
            let track = &self.tracks[side];
            let middle = self
                .body
                .place(0.5 * (track.cell(0, 1.0) + track.cell(CELLS - 1, 1.0)));
            if track.speed.abs() < SLOWEST {
                0.0
            } else {
                1.0 - self.body.velocity_at(middle).dot(forward) / track.speed
            }
        })
    }
}
