//! Angles and fields of a robot that turns once.

use crate::estimate::ellipse::EllipseFit;
use crate::math::{atan2, sqrt};

/// Shortest step of the field from one reading to the next whose direction counts, uT.
const SHORTEST_STEP: f32 = 2.0;

/// Turn on level ground.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Turn {
    /// Time since the start, s.
    pub time: f32,
    /// Angle by the gyroscope, and by the field, rad; counter-clockwise is positive.
    pub angle: f32,
    pub by_field: f32,
    /// Field before, and the last step from one field to the next, uT.
    before: Option<[f32; 2]>,
    step: Option<[f32; 2]>,
    pub fit: EllipseFit,
}

impl Turn {
    /// Adds a field in body axes, uT.
    pub fn add(&mut self, [x, y, _]: [f32; 3]) {
        if !(x.is_finite() && y.is_finite()) {
            return;
        }
        let first = self.fit.count() == 0;
        if first {
            self.fit = EllipseFit::around([x, y]);
        }
        self.fit.add([x, y]);
        // The direction of each step turns with the field, whatever the hard iron is.
        if let Some([before_x, before_y]) = self.before {
            let step = [x - before_x, y - before_y];
            let size = sqrt(step[0] * step[0] + step[1] * step[1]);
            if size < SHORTEST_STEP {
                return;
            }
            if let Some(last) = self.step {
                let across = last[0] * step[1] - last[1] * step[0];
                self.by_field += atan2(across, last[0] * step[0] + last[1] * step[1]);
            }
            self.step = Some(step);
        }
        self.before = Some([x, y]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The field makes a long step, and then one whose direction is turned by half a radian. The
    /// noise of a magnetometer turns shorter steps than 2 uT any way.
    #[test]
    fn a_step_of_the_field_counts_from_2_microtesla_on_whatever_its_direction_is() {
        let step = |size: f32, angle: f32| [size * libm::cosf(angle), size * libm::sinf(angle)];
        for direction in (0..16).map(|eighth| eighth as f32 * core::f32::consts::FRAC_PI_8) {
            for (size, expected) in [(0.3, 0.0), (1.9, 0.0), (2.1, 0.5), (9.0, 0.5)] {
                let mut turn = Turn::default();
                let [x, y] = step(9.0, direction);
                let [further_x, further_y] = step(size, direction + 0.5);
                turn.add([0.0; 3]);
                turn.add([x, y, 0.0]);
                turn.add([x + further_x, y + further_y, 0.0]);
                let found = turn.by_field;
                assert!(
                    (found - expected).abs() < 1e-3,
                    "{direction} {size}: {found}"
                );
            }
        }
        let mut turn = Turn::default();
        for field in [[0.0; 3], [0.0, 8.0, 0.0], [-2.0, 8.0, 0.0]] {
            turn.add(field);
        }
        assert!((turn.by_field - core::f32::consts::FRAC_PI_2).abs() < 1e-3);
    }
}
