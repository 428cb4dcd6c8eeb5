//! Speeds from which an instant stop tips a robot over an edge.
//!
//! An instant stop turns the motion into a rotation about the edge with the angular momentum of a
//! point mass, the smallest inertia that a body can have. The robot falls over if this rotation
//! lifts the centre of gravity above the edge: `v^2 = 2 g (l - h) l^2 / k^2`, with the distance
//! `l` of the centre of gravity to the edge, its height `h` over the edge, and its distance `k` to
//! the line on which the edge moves. On level ground `k = h`.

use super::criterion::{Evaluation, GRAVITY};
use super::support::{Edge, Stance};
use crate::math::{max, root_of_sum};

/// Smallest `k`, m: a lower centre of gravity does not limit the speed.
const MIN_ARM: f32 = 1e-3;

/// Speed from which an instant stop can tip a robot over an edge on level ground, m/s.
///
/// `margin` is the distance of the centre of gravity to the edge, `height` its height over the
/// edge, m. Infinite for a height of zero or less, NaN for NaN.
#[inline]
pub fn stopping_speed(margin: f32, height: f32) -> f32 {
    if height <= 0.0 {
        return f32::INFINITY;
    }
    stop_moment(margin, height) / height
}

/// The speed limit of [`stopping_speed`] times `k`, m^2/s: `sqrt(2 g (l - h) l^2)`.
#[inline]
fn stop_moment(margin: f32, height: f32) -> f32 {
    let square = margin * margin + height * height;
    // l - h without cancellation.
    let rise = margin * margin / (root_of_sum(square) + height);
    root_of_sum(2.0 * GRAVITY * rise * square)
}

/// Largest forward or backward speed, m/s, at which an instant stop does not tip a robot over the
/// edge ahead, on the plane that it stands on now; and that edge.
///
/// `found` has the margins of the centre of gravity and the levers of `stance`; `widening` is
/// the uncertainty of the masses, m. The plane is that of the support's sides
/// ([`Stance::along`]). A side slope tilts the edge; the lever is then longer than the height
/// across the edge, and the limit lower than needed. Zero if the centre of gravity is not inside
/// the edge or a value is NaN; infinite if the stop does not turn the robot toward the edge.
#[inline(never)]
pub fn speed_limit(
    stance: &Stance,
    found: &Evaluation,
    forward: f32,
    widening: f32,
) -> (f32, Edge) {
    let (edge, direction) = if forward < 0.0 {
        (Edge::Back, -1.0)
    } else {
        (Edge::Front, 1.0)
    };
    let margin = found.gravity[edge as usize];
    let [ahead, aside] = found.levers[edge as usize];
    let [cosine, sine] = stance.along();
    // Distance of the centre of gravity to the line through the edge along the plane.
    let arm = direction * cosine * ahead + direction * sine * margin + widening;
    let height = root_of_sum(ahead * ahead + aside * aside) + widening;
    let limit = stop_moment(max(margin, 0.0), height) / max(arm, MIN_ARM);
    let limit = if arm <= 0.0 { f32::INFINITY } else { limit };
    // All false for NaN.
    let inside = margin > 0.0 && limit >= 0.0 && arm.is_finite();
    (if inside { limit } else { 0.0 }, edge)
}
