//! What a robot bears that falls off a step behind it.
//!
//! A robot that backs, or that moves its centre of gravity back, may have a nose behind it that it
//! does not see: the one that it climbed. When its centre of gravity passes the nose, the robot turns
//! about it until its rear meets the ground below. From then on it turns about its rear, and falls over
//! if this lifts the centre of gravity above the rear.
//!
//! A front that is folded down makes it worse: it lifts the body, and after the fall the robot stands on
//! its rear alone. So it backs only at the speed that it bears, and folds its front only as far as it
//! bears such a fall at all.

use super::criterion::GRAVITY;
use super::filter::{SMALLEST_SHARE, Verdict};
use super::support::{Edge, Stance};
use crate::math::{max, min, root_of_sum};

/// A lower centre of gravity turns nothing, m.
const LOWEST: f32 = 1e-3;

/// What a robot bears, as a height that its speed is worth, m: `v^2 / 2 g` of the largest speed at
/// which it may pass a nose of the height `step` (m). Negative if it falls over at any speed,
/// infinite if nothing turns it. NaN for NaN.
///
/// The nose is under the centre of gravity, on the plane that the robot stands on; a plane with the
/// nose down counts as level. The body is a point mass at the height `n` over the nose, `h` over the
/// rear and `l` from the rear, which is `b` from the nose along the plane. It turns by `d`, from the
/// slope of the plane to the angle whose sine is `step / b`, and gains the height `f = n (1 - cos d)`.
/// Angular momentum about the rear is kept when the rear meets the ground: `(f + v^2 / 2 g) h^2 / l^2`
/// is left of the energy. It must not lift the centre of gravity from `n cos d + step` to `l`.
/// `widening` is the uncertainty of the masses, m.
pub fn room(stance: &Stance, step: f32, widening: f32) -> f32 {
    let [rear_x, rear_z] = stance.middle(Edge::Back);
    let ahead = stance.cog[0] - rear_x - widening;
    let height = stance.cog[2] - rear_z + widening;
    let [cosine, sine] = stance.along();
    let (cosine, sine) = if sine < 0.0 {
        (1.0, 0.0)
    } else {
        (cosine, sine)
    };
    let over_nose = height - ahead * sine / cosine;
    let steep = min(step * cosine / ahead, 1.0);
    // A robot whose centre of gravity is behind its rear has fallen already.
    if ahead <= 0.0 && step > 0.0 {
        return -step;
    }
    // False for NaN.
    if step <= 0.0 || steep <= sine || over_nose < LOWEST {
        return f32::INFINITY;
    }
    let turned = root_of_sum(max(1.0 - steep * steep, 0.0)) * cosine + steep * sine;
    let square = ahead * ahead + height * height;
    let bears = root_of_sum(square) - over_nose * turned - step;
    bears * square / (height * height) - over_nose * (1.0 - turned)
}

/// Speed that is worth this height, m/s; zero for a height below zero and for NaN.
pub fn speed(room: f32) -> f32 {
    if room > 0.0 {
        root_of_sum(2.0 * GRAVITY * room)
    } else {
        0.0
    }
}

/// Room below which a motion that lifts the front of the body is slow, m.
const NARROW: f32 = 0.02;

/// Lowers the share of a posture's motion that lifts the front of the body, so that it slows down and
/// ends with the room. NaN refuses.
pub fn within((share, verdict): (f32, Verdict), room: f32) -> (f32, Verdict) {
    let left = room / NARROW;
    if left >= share {
        return (share, verdict);
    }
    // False for NaN.
    if left > SMALLEST_SHARE {
        (left, Verdict::PostureScaled(Edge::Back))
    } else {
        (0.0, Verdict::PostureRefused(Edge::Back))
    }
}

#[cfg(test)]
mod tests {
    use super::super::filter::Verdict;
    use super::*;

    const G: f64 = 9.806_65;
    const TICK: f64 = 2e-5;

    /// A support with this slope (rad), and the centre of gravity at `ahead` of its rear edge and
    /// `up` from it, m.
    fn stance(slope: f64, ahead: f64, up: f64) -> Stance {
        let front = [0.6 * libm::cos(slope), 0.6 * libm::sin(slope)].map(|value| value as f32);
        let contacts = [
            [0.0, -0.2, 0.0],
            [front[0], -0.2, front[1]],
            [front[0], 0.2, front[1]],
            [0.0, 0.2, 0.0],
        ];
        Stance::on(contacts, [ahead as f32, 0.0, up as f32])
    }

    /// Whether a point mass that passes the nose with this speed falls over its rear. Both rotations
    /// are integrated, about the nose and about the rear.
    fn falls_over(slope: f64, [ahead, up]: [f64; 2], step: f64, speed: f64) -> bool {
        let base = ahead / libm::cos(slope);
        let mut over_nose = [0.0, up - ahead * libm::tan(slope)];
        let mut rear = [-ahead, -ahead * libm::tan(slope)];
        let radius = over_nose[1];
        let (mut angle, mut rate) = (0.0_f64, speed / radius);
        // The rear sinks until it meets the ground, or hangs straight down.
        while rear[1] > -step && angle + slope < core::f64::consts::FRAC_PI_2 {
            rate += G * libm::sin(angle) / radius * TICK;
            angle += rate * TICK;
            rear = [
                -base * libm::cos(slope + angle),
                -base * libm::sin(slope + angle),
            ];
            over_nose = [-radius * libm::sin(angle), radius * libm::cos(angle)];
        }
        let velocity = [-rate * over_nose[1], rate * over_nose[0]];
        let mut arm = [over_nose[0] - rear[0], over_nose[1] + step];
        let square = arm[0] * arm[0] + arm[1] * arm[1];
        let mut rate = (arm[0] * velocity[1] - arm[1] * velocity[0]) / square;
        // The angle of the centre of gravity before the vertical over the rear.
        let mut left = libm::atan2(arm[0], arm[1]);
        let start = left;
        for _ in 0..500_000 {
            if left <= 0.0 {
                return true;
            }
            if left > start {
                return false;
            }
            rate -= G * libm::sin(left) / libm::sqrt(square) * TICK;
            left -= rate * TICK;
            arm = [libm::sin(left), libm::cos(left)];
        }
        panic!("undecided: {arm:?}");
    }

    #[test]
    fn at_the_speed_of_the_room_the_fall_off_a_step_behind_is_borne_and_above_it_not() {
        let (mut borne, mut not) = (0, 0);
        for slope in [0.0, 0.2, 0.5] {
            for ahead in [0.08, 0.12, 0.16, 0.2, 0.25, 0.3] {
                for up in [0.12, 0.18, 0.25, 0.32] {
                    for step in [0.05, 0.1, 0.15] {
                        let place = [ahead, up];
                        let room = room(&stance(slope, ahead, up), step as f32, 0.0);
                        let case = (slope, place, step, room);
                        if room == f32::INFINITY {
                            let steep = step * libm::cos(slope) <= ahead * libm::sin(slope);
                            assert!(steep || up < ahead * libm::tan(slope) + 2e-3, "{case:?}");
                            continue;
                        }
                        if room <= 0.0 {
                            // Whatever it has is too much: the fall begins at some speed.
                            assert!(falls_over(slope, place, step, 0.02), "{case:?}");
                            not += 1;
                            continue;
                        }
                        let limit = f64::from(speed(room));
                        assert!(!falls_over(slope, place, step, 0.98 * limit), "{case:?}");
                        assert!(falls_over(slope, place, step, 1.02 * limit), "{case:?}");
                        borne += 1;
                    }
                }
            }
        }
        assert!(borne > 50 && not > 50, "{borne} {not}");
    }

    #[test]
    fn a_motion_that_lifts_the_front_slows_down_and_ends_with_the_room() {
        let passed = (1.0, Verdict::Passed);
        for wide in [0.02, 0.1, f32::INFINITY] {
            assert_eq!(within(passed, wide), passed);
        }
        let half = (0.5, Verdict::PostureScaled(Edge::Back));
        assert_eq!(within(passed, 0.01), half);
        for none in [0.0, -0.1, f32::NAN] {
            let refused = (0.0, Verdict::PostureRefused(Edge::Back));
            assert_eq!(within(passed, none), refused);
        }
        let slower = (0.2, Verdict::PostureScaled(Edge::Left));
        assert_eq!(within(slower, 0.01), slower);
    }

    #[test]
    fn without_a_step_nothing_falls_and_nan_leaves_no_speed() {
        for ahead in [0.2, 0.0, -0.1] {
            assert_eq!(room(&stance(0.0, ahead, 0.2), 0.0, 0.0), f32::INFINITY);
            assert!(ahead > 0.0 || room(&stance(0.0, ahead, 0.2), 0.1, 0.0) < 0.0);
        }
        let mut broken = stance(0.0, 0.2, 0.2);
        broken.cog[2] = f32::NAN;
        let room = room(&broken, 0.1, 0.0);
        assert_eq!(speed(room), 0.0);
    }

    #[test]
    fn what_is_not_known_of_the_masses_takes_from_the_room() {
        let stance = stance(0.0, 0.2, 0.2);
        assert!(room(&stance, 0.08, 0.02) < room(&stance, 0.08, 0.0) - 0.01);
    }
}
