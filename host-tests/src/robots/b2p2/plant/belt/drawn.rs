//! The line through which a belt is drawn: its straight pieces, and the arcs around the pulleys.

use super::Belt;
use rapier3d_f64::math::Vector;
use std::f64::consts::TAU;

/// Distance between two straight pieces from which there is an arc between them, m. At a corner of
/// the ground there is none.
const GAP: f64 = 0.003;
/// Maximum angle between two points of an arc, rad.
const STEP: f64 = 0.2;

impl Belt {
    /// Points of the closed line, m. `left` is the direction of the pulleys' axes.
    pub fn drawn(&self, left: Vector, radius: f64) -> Vec<[f64; 3]> {
        let (pieces, _) = self.course.as_chunks::<2>();
        let mut points = Vec::new();
        for (index, piece) in pieces.iter().enumerate() {
            points.extend(piece.map(|end| end.to_array()));
            let next = pieces[(index + 1) % pieces.len()];
            let (end, begin) = (piece[1], next[0]);
            if (begin - end).length() < GAP {
                continue;
            }
            let [from, to] = [piece, &next].map(|of| (of[1] - of[0]).normalize_or_zero());
            // The belts run around the pulleys from forward to up.
            let inward = from.cross(left);
            let centre = end + inward * radius;
            let turn = libm::atan2(to.dot(inward), to.dot(from)).rem_euclid(TAU);
            let steps = (turn / STEP).ceil() as u32;
            points.extend((1..steps).map(|step| {
                let angle = turn * f64::from(step) / f64::from(steps);
                let (sine, cosine) = libm::sincos(angle);
                (centre + (from * sine - inward * cosine) * radius).to_array()
            }));
        }
        points
    }
}
