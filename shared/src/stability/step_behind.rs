//! Computes the speed at which a robot may fall backward off a step without toppling.
//!
//! A robot that drives backward may have the nose (front edge) of a step behind it that it does not
//! see: the one that it climbed. When its centre of gravity passes the nose, the robot turns about
//! the nose until its rear meets the ground below. From then on it turns about its rear, and it
//! topples if its centre of gravity passes the vertical over the rear.
//!
//! A front that is folded down makes the fall worse: it lifts the body, and after the fall the
//! robot stands on its rear alone. So the robot drives backward only at a speed at which the fall
//! does not topple it. And it folds its front down only as far as there is such a speed. Raising
//! the front and turning on the spot can also bring the centre of gravity over a nose. They are not
//! limited here.

use super::filter::{SMALLEST_SHARE, Verdict};
use super::support::{Edge, Stance};
use crate::constants::GRAVITY;
use crate::math::{max, min, root_of_sum};

/// Height of the centre of gravity over the nose below which the nose does not turn the robot, m.
const LOWEST: f32 = 1e-3;

/// Step that may be behind a robot, and the robot's inertia in the fall.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct StepBehind {
    /// Height, m; 0 if there is no step, or if a fall does the robot no harm.
    pub height: f32,
    /// Square of the robot's radius of gyration about its transverse axis, m^2.
    pub gyration: f32,
}

impl StepBehind {
    /// No step.
    pub const NONE: Self = Self {
        height: 0.0,
        gyration: 0.0,
    };
}

/// Largest speed `v` at which a robot may pass the nose of this step without toppling, expressed as
/// the height `v^2 / 2 g`, m. Negative if the robot topples at any speed, infinite if nothing turns
/// it. NaN for NaN.
///
/// The nose is under the centre of gravity, on the line from the rear along the support. A support
/// whose front is lower counts as level. The bottom of the robot is straight. The centre of gravity
/// is `n` above the nose, `h` above the rear and `l` from the rear; the rear is `b` from the nose;
/// the radius of gyration is `k`. Energies are expressed as heights, too.
///
/// The robot turns about the nose by `d`, from the slope of the support to the angle whose sine is
/// `height / b`. With its speed it then has the energy
/// `e = n (1 - cos d) + v^2 / 2 g n^2 / (n^2 + k^2)`. When the rear meets the ground, the angular
/// momentum about the rear is preserved, and the energy
/// `e (n h + k^2)^2 / ((n^2 + k^2) (l^2 + k^2))` is left. It must not lift the centre of gravity
/// from `n cos d + height` to `l`. `deduction` is the uncertainty of the masses, m.
pub fn room(stance: &Stance, step: &StepBehind, deduction: f32) -> f32 {
    let (step, gyration) = (step.height, step.gyration);
    let [rear_x, rear_z] = stance.rear();
    let ahead = stance.cog[0] - rear_x - deduction;
    let height = stance.cog[2] - rear_z + deduction;
    let [cosine, sine] = stance.rising();
    // The centre of gravity is behind the rear: the robot falls without any step.
    if ahead <= 0.0 && step > 0.0 {
        return -step;
    }
    let over_nose = height - ahead * sine / cosine;
    let steep = min(step * cosine / ahead, 1.0);
    // The comparisons are false for NaN.
    if step <= 0.0 || steep <= sine || over_nose < LOWEST {
        return f32::INFINITY;
    }
    let turned = root_of_sum(max(1.0 - steep * steep, 0.0)) * cosine + steep * sine;
    let square = ahead * ahead + height * height;
    let bears = root_of_sum(square) - over_nose * turned - step;
    let about_nose = over_nose * over_nose + gyration;
    let across = over_nose * height + gyration;
    let borne = bears * about_nose * (square + gyration) / (across * across);
    (borne - over_nose * (1.0 - turned)) * about_nose / (over_nose * over_nose)
}

/// Speed `v` of a height `v^2 / 2 g`, m/s; zero for a height below zero and for NaN.
pub fn speed(room: f32) -> f32 {
    if room > 0.0 {
        root_of_sum(2.0 * GRAVITY * room)
    } else {
        0.0
    }
}

/// Room below which a posture motion that lifts the front of the body slows down, m.
const NARROW: f32 = 0.02;

/// Lowers the scale of a posture motion that lifts the front of the body, so that the motion slows
/// down and ends as the `room` (m, from [`room()`]) is used up.
///
/// `floor` is the scale that passes however little room there is. NaN refuses.
pub fn within((scale, verdict): (f32, Verdict), room: f32, floor: f32) -> (f32, Verdict) {
    let remaining = max(room / NARROW, floor);
    if remaining >= scale {
        return (scale, verdict);
    }
    // The comparison is false for NaN. Only the verdict changes at the smallest scale; a jump of
    // the scale would make the motion stop and start.
    let verdict = if remaining > SMALLEST_SHARE {
        Verdict::PostureScaled(Edge::Back)
    } else {
        Verdict::PostureRefused(Edge::Back)
    };
    (if remaining > 0.0 { remaining } else { 0.0 }, verdict)
}

#[cfg(test)]
mod tests {
    use super::super::filter::Verdict;
    use super::*;

    const G: f64 = 9.81;
    const TICK: f64 = 2e-5;
    const GYRATION: f32 = 0.053;

    fn step(height: f32) -> StepBehind {
        StepBehind {
            height,
            gyration: GYRATION,
        }
    }

    /// Stance on a support with this slope, rad. The centre of gravity is `ahead` in front of the
    /// rear edge and `up` above it, m.
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

    /// Whether a body that passes the nose with this speed topples over its rear. Integrates both
    /// rotations, about the nose and about the rear.
    fn falls_over(slope: f64, [ahead, up]: [f64; 2], step: f64, speed: f64) -> bool {
        let gyration = f64::from(GYRATION);
        let base = ahead / libm::cos(slope);
        let mut over_nose = [0.0, up - ahead * libm::tan(slope)];
        let mut rear = [-ahead, -ahead * libm::tan(slope)];
        let radius = over_nose[1];
        let inertia = radius * radius + gyration;
        let (mut angle, mut rate) = (0.0_f64, speed * radius / inertia);
        // The rear sinks until it meets the ground or hangs straight down.
        while rear[1] > -step && angle + slope < core::f64::consts::FRAC_PI_2 {
            rate += G * radius * libm::sin(angle) / inertia * TICK;
            angle += rate * TICK;
            rear = [
                -base * libm::cos(slope + angle),
                -base * libm::sin(slope + angle),
            ];
            over_nose = [-radius * libm::sin(angle), radius * libm::cos(angle)];
        }
        let velocity = [-rate * over_nose[1], rate * over_nose[0]];
        let arm = [over_nose[0] - rear[0], over_nose[1] + step];
        let square = arm[0] * arm[0] + arm[1] * arm[1];
        let momentum = arm[0] * velocity[1] - arm[1] * velocity[0] + gyration * rate;
        let mut rate = momentum / (square + gyration);
        // Angle of the centre of gravity to the vertical over the rear.
        let mut left = libm::atan2(arm[0], arm[1]);
        let start = left;
        for _ in 0..500_000 {
            if left <= 0.0 {
                return true;
            }
            if left > start {
                return false;
            }
            rate -= G * libm::sqrt(square) * libm::sin(left) / (square + gyration) * TICK;
            left -= rate * TICK;
        }
        panic!("undecided");
    }

    #[test]
    fn at_the_speed_of_the_room_the_fall_off_a_step_behind_is_borne_and_above_it_not() {
        let (mut borne, mut not) = (0, 0);
        for slope in [0.0, 0.2, 0.5] {
            for ahead in [0.08, 0.12, 0.16, 0.2, 0.25, 0.3] {
                for up in [0.12, 0.18, 0.25, 0.32] {
                    for high in [0.05, 0.1, 0.15] {
                        let place = [ahead, up];
                        let room = room(&stance(slope, ahead, up), &step(high as f32), 0.0);
                        let case = (slope, place, high, room);
                        if room == f32::INFINITY {
                            let steep = high * libm::cos(slope) <= ahead * libm::sin(slope);
                            assert!(steep || up < ahead * libm::tan(slope) + 2e-3, "{case:?}");
                            continue;
                        }
                        if room <= 0.0 {
                            // Without room the robot topples even at a very low speed.
                            assert!(falls_over(slope, place, high, 0.02), "{case:?}");
                            not += 1;
                            continue;
                        }
                        let limit = f64::from(speed(room));
                        assert!(!falls_over(slope, place, high, 0.98 * limit), "{case:?}");
                        assert!(falls_over(slope, place, high, 1.02 * limit), "{case:?}");
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
            assert_eq!(within(passed, wide, 0.0), passed);
        }
        let half = (0.5, Verdict::PostureScaled(Edge::Back));
        assert_eq!(within(passed, 0.01, 0.0), half);
        assert_eq!(within(passed, -0.01, 0.5), half);
        let creeping = (0.01, Verdict::PostureRefused(Edge::Back));
        assert_eq!(within(passed, 0.01 * NARROW, 0.0), creeping);
        for none in [0.0, -0.1, f32::NAN] {
            let refused = (0.0, Verdict::PostureRefused(Edge::Back));
            assert_eq!(within(passed, none, 0.0), refused);
        }
        let slower = (0.2, Verdict::PostureScaled(Edge::Left));
        assert_eq!(within(slower, 0.01, 0.0), slower);
    }

    #[test]
    fn without_a_step_nothing_falls_and_nan_leaves_no_speed() {
        for ahead in [0.2, 0.0, -0.1] {
            assert_eq!(
                room(&stance(0.0, ahead, 0.2), &step(0.0), 0.0),
                f32::INFINITY
            );
            assert!(ahead > 0.0 || room(&stance(0.0, ahead, 0.2), &step(0.1), 0.0) < 0.0);
        }
        let mut broken = stance(0.0, 0.2, 0.2);
        broken.cog[2] = f32::NAN;
        let room = room(&broken, &step(0.1), 0.0);
        assert_eq!(speed(room), 0.0);
    }

    /// The uncertainty moves the centre of gravity both back and up, and both reduce the room.
    #[test]
    fn what_is_not_known_of_the_masses_takes_from_the_room() {
        let uncertain = room(&stance(0.0, 0.2, 0.2), &step(0.08), 0.02);
        let moved = room(&stance(0.0, 0.18, 0.22), &step(0.08), 0.0);
        assert!((uncertain - moved).abs() < 1e-6, "{uncertain} {moved}");
        assert!(moved < room(&stance(0.0, 0.2, 0.2), &step(0.08), 0.0) - 0.01);
    }

    #[test]
    fn a_support_whose_front_is_lower_counts_as_level() {
        let level = room(&stance(0.0, 0.2, 0.2), &step(0.1), 0.0);
        assert_eq!(room(&stance(-0.3, 0.2, 0.2), &step(0.1), 0.0), level);
    }

    /// The rear hangs straight down before it meets the ground.
    #[test]
    fn a_step_that_is_deeper_than_the_rear_reaches_is_borne_as_little_as_one_that_it_just_reaches()
    {
        let at = |height| room(&stance(0.0, 0.1, 0.2), &step(height), 0.0);
        assert!(at(0.1) < 0.0 && at(0.15) < at(0.1) && at(0.15).is_finite());
    }
}
