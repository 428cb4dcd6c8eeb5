//! Computes the speeds from which an instant stop tips a robot over an edge.
//!
//! An instant stop turns the motion into a rotation about the edge. The angular momentum is that of
//! a point mass, because a point mass is the smallest inertia that a body can have. The robot
//! topples if this rotation lifts the centre of gravity above the edge:
//! `v^2 = 2 g (l - h) l^2 / k^2`. Here `l` is the distance of the centre of gravity to the edge,
//! `h` its height over the edge, and `k` its distance to the line on which the edge moves. On level
//! ground `k = h`.

use super::evaluation::Evaluation;
use super::support::{Edge, Stance};
use crate::constants::GRAVITY;
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
    // `l - h` without cancellation.
    let rise = margin * margin / (root_of_sum(square) + height);
    root_of_sum(2.0 * GRAVITY * rise * square)
}

/// Largest forward or backward speed, m/s, at which an instant stop does not tip a robot over the
/// edge ahead, on the plane that it stands on now; and that edge.
///
/// `found` has the margins of the centre of gravity and the levers of `stance`; `deduction` is the
/// uncertainty of the masses, m. The plane is that of the support's sides ([`Stance::along`]). A
/// side slope tilts the edge; the lever is then longer than the height across the edge, and the
/// limit is lower than necessary. The limit is also lower than necessary for a centre of gravity
/// below the edge, which is treated as if it were as far above it. Zero if the centre of gravity is
/// not inside the edge or a value is NaN; infinite if the stop does not turn the robot toward the
/// edge.
#[inline(never)]
pub fn speed_limit(
    stance: &Stance,
    found: &Evaluation,
    forward: f32,
    deduction: f32,
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
    let arm = direction * cosine * ahead + direction * sine * margin + deduction;
    let height = root_of_sum(ahead * ahead + aside * aside) + deduction;
    let limit = stop_moment(max(margin, 0.0), height) / max(arm, MIN_ARM);
    let limit = if arm <= 0.0 { f32::INFINITY } else { limit };
    // All comparisons are false for NaN.
    let inside = margin > 0.0 && limit >= 0.0 && arm.is_finite();
    (if inside { limit } else { 0.0 }, edge)
}

#[cfg(test)]
mod tests {
    use super::super::criterion::Criterion;
    use super::super::parameters::Parameters;
    use super::*;
    use crate::settings::Settings;

    /// Whether a point mass turns over an edge that stops at once. The mass is at `place` (forward
    /// and up from the edge, m) and moves with `velocity`, m/s; the edge lies in the `direction` of
    /// the motion. Integrates the rigid rotation about the edge with steps of 50 us.
    fn tips(place: [f64; 2], velocity: [f64; 2], direction: f64) -> bool {
        const STEP: f64 = 5e-5;
        let [x, z] = place;
        let square = x * x + z * z;
        // Angle of the mass from the vertical over the edge, positive behind the edge.
        let mut angle = libm::atan2(-direction * x, z);
        let start = angle;
        // Angular momentum of the motion about the edge; its positive sense is away from the edge.
        let mut rate = direction * (x * velocity[1] - z * velocity[0]) / square;
        for _ in 0..200_000 {
            rate += 9.81 * libm::sin(angle) / libm::sqrt(square) * STEP;
            angle += rate * STEP;
            if angle < 0.0 {
                return true;
            }
            if angle > start {
                return false;
            }
        }
        false
    }

    /// A support 0.6 m long on a plane with this pitch (rad), and the centre of gravity at `along`
    /// from its rear edge and `up` from the plane, m.
    fn stance(pitch: f64, along: f64, up: f64) -> Stance {
        let (sine, cosine) = (libm::sin(pitch), libm::cos(pitch));
        let place = |along: f64, left: f64, up: f64| {
            [along * cosine - up * sine, left, along * sine + up * cosine]
                .map(|coordinate| coordinate as f32)
        };
        let contacts = [
            place(0.0, -0.2, 0.0),
            place(0.6, -0.2, 0.0),
            place(0.6, 0.2, 0.0),
            place(0.0, 0.2, 0.0),
        ];
        Stance::on(contacts, place(along, 0.0, up))
    }

    fn limit(stance: &Stance, forward: f32) -> (f32, Edge) {
        let parameters = Parameters::new(&Settings::default());
        let level = [0.0, 0.0, GRAVITY];
        let found = Criterion::default().evaluate(stance, level, 0.0, &parameters);
        speed_limit(stance, &found, forward, 0.0)
    }

    #[test]
    fn at_the_speed_limit_an_instant_stop_tips_nothing_on_any_plane() {
        let mut checked = 0;
        for pitch in [-0.8, -0.4, 0.0, 0.4, 0.8] {
            for along in [0.05, 0.15, 0.3, 0.45, 0.55] {
                for up in [0.08, 0.15, 0.3] {
                    for direction in [1.0, -1.0] {
                        let (limit, edge) = limit(&stance(pitch, along, up), direction as f32);
                        let from_edge = if direction > 0.0 { along - 0.6 } else { along };
                        let (sine, cosine) = (libm::sin(pitch), libm::cos(pitch));
                        let place = [
                            from_edge * cosine - up * sine,
                            from_edge * sine + up * cosine,
                        ];
                        if direction * place[0] >= 0.0 {
                            assert_eq!(limit, 0.0, "outside of the edge");
                            continue;
                        }
                        let tips_at = |speed: f64| {
                            let velocity = [cosine, sine].map(|part| direction * speed * part);
                            tips(place, velocity, direction)
                        };
                        let limit = f64::from(limit);
                        assert!(!tips_at(0.99 * limit), "{pitch} {along} {up} {edge:?}");
                        // A centre of gravity below the edge is treated as if it were as far above
                        // it.
                        let exact = place[1] > 0.0;
                        assert!(
                            !exact || tips_at(1.01 * limit),
                            "{pitch} {along} {up} {edge:?}"
                        );
                        checked += 1;
                    }
                }
            }
        }
        assert!(checked > 60, "{checked}");
    }

    #[test]
    fn nan_leaves_no_speed() {
        let mut contacts = stance(0.1, 0.3, 0.2);
        assert!(limit(&contacts, 0.1).0 > 0.3);
        contacts.cog[2] = f32::NAN;
        for forward in [0.1, -0.1] {
            assert_eq!(limit(&contacts, forward).0, 0.0);
        }
    }
}
