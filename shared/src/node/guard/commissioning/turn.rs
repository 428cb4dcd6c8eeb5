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
