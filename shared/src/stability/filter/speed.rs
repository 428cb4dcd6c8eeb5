//! Computes the scale of a commanded speed.

use super::bounds::{Bounds, Ramp, scale};
use super::{Margins, Verdict};
use crate::math::{max, min};
use crate::stability::allowed::Command;
use crate::stability::support::{EDGES, Edge};

/// Speed at which half of a margin's rate is attributed to the command, m/s. Below this speed, most
/// of the rate is noise.
const ATTRIBUTION_SPEED: f32 = 0.02;
/// Bisections in the search for a scale, before a linear interpolation.
const BISECTIONS: usize = 6;

/// Whether a command with this forward speed, at this pitch, can use up the margin to an edge by
/// itself.
///
/// These motions can:
///
/// * Rear edge: driving forward while pitched up (the motion that lifted the front continues to
///   lift it), and driving backward on level ground or pitched down.
/// * Front edge: driving forward or backward on level ground or pitched down.
/// * Left and right edge: every motion.
///
/// Other motions lead away from the edge. They can still use up its margin when the ground ends or
/// when they stop; the decay of the margin and the energy of a stop cover these cases. At a NaN
/// pitch a motion leads to every edge, except to the rear edge at forward speed zero.
fn leads_to(edge: Edge, forward: f32, pitch: f32) -> bool {
    match edge {
        Edge::Back if forward > 0.0 => !(pitch <= 0.0),
        Edge::Back => !(forward == 0.0 || pitch > 0.0),
        Edge::Front => !(pitch > 0.0),
        Edge::Left | Edge::Right => true,
    }
}

/// Scale of the commanded speed, 0 to 1, and the verdict. Refuses a command that is not finite.
///
/// If the robot is pitched up at the nose of a step and turns, an outer side that drives forward
/// lifts the front further. Then the rear edge counts as in driving forward ([`Bounds::lifts`]).
pub fn speed_scale(
    command: Command<()>,
    pitch: f32,
    margins: &Margins,
    bounds: &Bounds,
) -> (f32, Verdict) {
    let forward = command.forward;
    if !(forward + command.yaw_rate).is_finite() {
        return (0.0, Verdict::Refused(Edge::Back));
    }
    let lifts = bounds.lifts(command, pitch);
    let (mut scale, mut verdict) = (1.0, Verdict::Passed);
    for edge in EDGES {
        let kept = || passable(command, pitch, edge, margins, bounds.towards, bounds);
        let remaining = if leads_to(edge, forward, pitch) {
            kept()
        } else {
            let end = Ramp {
                none: bounds.away.none,
                all: bounds.away.none,
            };
            let slow = bounds.away.scale(margins.now[edge as usize]);
            let away = min(slow, passable(command, pitch, edge, margins, end, bounds));
            if lifts > 0.0 && edge == Edge::Back {
                min(away, 1.0 - lifts * (1.0 - kept()))
            } else {
                away
            }
        };
        if remaining < scale {
            scale = remaining;
            verdict = if remaining > 0.0 {
                Verdict::Scaled(edge)
            } else {
                Verdict::Refused(edge)
            };
        }
    }
    (scale, verdict)
}

/// Lowers a scale so that the scaled speed stays within the `limit` (m/s) of an edge.
pub fn within_limit(
    (scale, verdict): (f32, Verdict),
    forward: f32,
    (limit, edge): (f32, Edge),
) -> (f32, Verdict) {
    let speed = forward.abs();
    if speed * scale <= limit {
        return (scale, verdict);
    }
    let remaining = limit / speed;
    // The comparison is false for NaN.
    match remaining > 0.0 {
        true if remaining < scale => (remaining, Verdict::Scaled(edge)),
        true => (scale, verdict),
        false => (0.0, Verdict::Refused(edge)),
    }
}

/// Scale that one edge allows, always 0 to 1: the largest with which the margin in terms of energy
/// ([`Tipping::margin`]) stays above the ramp.
///
/// [`Tipping::margin`]: crate::stability::energy::Tipping::margin
fn passable(
    command: Command<()>,
    pitch: f32,
    edge: Edge,
    margins: &Margins,
    ramp: Ramp,
    bounds: &Bounds,
) -> f32 {
    let forward = command.forward;
    let (now, rate) = (margins.now[edge as usize], margins.rate[edge as usize]);
    // The growth of a margin does not count.
    let rate = min(rate, 0.0);
    // Speed in the direction of the command.
    let along = if forward < 0.0 {
        -margins.speed
    } else {
        margins.speed
    };
    let along = if along > 0.0 { along } else { 0.0 };
    // Least squares for `rate = k speed`, biased to zero where the speed is too low to determine
    // `k`.
    let per_speed = -rate * along / (along * along + ATTRIBUTION_SPEED * ATTRIBUTION_SPEED);
    let rest = rate + per_speed * along;
    let toward = match edge {
        Edge::Back => max(-forward, 0.0),
        Edge::Front => max(forward, 0.0),
        Edge::Left | Edge::Right => 0.0,
    };
    let tipping = bounds.tipping[edge as usize];
    let nose = match edge {
        Edge::Back => bounds.nose(command, pitch),
        Edge::Front | Edge::Left | Edge::Right => None,
    };
    // Energy that is left with this scale, above what the scale requires, as a margin, m: as the
    // margin decays now, and on a nose.
    let spare = |scale: f32| {
        let decay = (rest - scale * per_speed * forward.abs()) * bounds.horizon;
        let left = tipping.margin(now + decay, scale * toward) - scale * ramp.width();
        let on_nose = nose.map_or(left, |nose| {
            let before = now + rest * bounds.horizon;
            tipping.margin(nose.left(before, tipping.height, scale), 0.0)
        });
        // The comparison is false for NaN.
        let least = if left <= on_nose { left } else { on_nose };
        least - ramp.none
    };
    let (mut low, mut high) = ((0.0, spare(0.0)), (1.0, spare(1.0)));
    // The comparisons are false for NaN.
    if high.1 >= 0.0 {
        return 1.0;
    }
    if !(low.1 > 0.0) {
        return 0.0;
    }
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low.0 + high.0);
        let found = (middle, spare(middle));
        if found.1 > 0.0 {
            low = found;
        } else {
            high = found;
        }
    }
    scale(low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1))
}

#[cfg(test)]
mod tests {
    use super::super::examples::{BOUNDS, STILL, standing};
    use super::*;
    use crate::stability::energy::Tipping;

    fn along(forward: f32) -> Command<()> {
        Command::new(forward, 0.0)
    }

    #[test]
    fn the_share_falls_from_all_to_nothing_through_the_caution_band() {
        assert_eq!(
            speed_scale(along(0.13), 0.5, &standing(0.10), &BOUNDS),
            (1.0, Verdict::Passed)
        );
        let (scale, verdict) = speed_scale(along(0.13), 0.5, &standing(0.07), &BOUNDS);
        assert!((scale - 0.5).abs() < 1e-5);
        assert_eq!(verdict, Verdict::Scaled(Edge::Back));
        assert_eq!(
            speed_scale(along(0.13), 0.5, &standing(0.04), &BOUNDS),
            (0.0, Verdict::Refused(Edge::Back))
        );
    }

    #[test]
    fn a_decay_that_the_command_does_not_cause_is_subtracted_from_the_margin() {
        let falling = Margins {
            rate: [-0.4, 0.0, 0.0, 0.0],
            ..standing(0.14)
        };
        // 140 mm minus 0.4 m/s for 0.25 s is below the stop margin.
        assert_eq!(
            speed_scale(along(0.13), 0.5, &falling, &BOUNDS),
            (0.0, Verdict::Refused(Edge::Back))
        );
    }

    /// Forward speed, m/s, and pitch, rad, of every kind of motion.
    const MOTIONS: [(f32, f32); 7] = [
        (0.3, 0.5),
        (0.3, 0.0),
        (0.3, -0.5),
        (-0.3, 0.5),
        (-0.3, 0.0),
        (-0.3, -0.5),
        (0.0, 0.5),
    ];

    /// Margin of an edge at the horizon, in double precision and steps of 0.1 ms, while the robot
    /// drives with the speed `scale u`. The margin falls by 1 m per metre driven, and by a decay of
    /// its own. The margin without the part of the caution band that belongs to the scale must not
    /// fall below the stop margin within the horizon.
    fn left_at_the_horizon(margin: f64, own_decay: f64, speed: f64, scale: f64) -> f64 {
        const STEP: f64 = 1e-4;
        let mut margin = margin - scale * f64::from(BOUNDS.towards.all - BOUNDS.towards.none);
        let mut time = 0.0;
        while time < f64::from(BOUNDS.horizon) {
            margin -= (own_decay + scale * speed) * STEP;
            time += STEP;
        }
        margin
    }

    /// Compares the scale with that of a brute-force search: the largest in steps of 0.001 with
    /// which the margin is not below the stop margin at the horizon.
    #[test]
    fn what_passes_is_the_most_that_does_not_cross_the_stop_margin_within_the_horizon() {
        for (margin, asked, driven, own_decay) in [
            (0.12, 0.2, 0.2, 0.0),
            (0.10, 0.4, 0.3, 0.0),
            (0.08, 0.1, 0.1, 0.0),
            (0.07, 0.45, 0.2, 0.0),
            (0.09, 0.45, 0.45, 0.0),
            // At rest the command causes none of the decay, and its own effect is not known yet.
            (0.09, 1e-6, 0.0, 0.1),
        ] {
            // The measured decay is that of a robot that drives at `driven`.
            let moving = Margins {
                rate: [-(driven + own_decay) as f32, 0.0, 0.0, 0.0],
                speed: driven as f32,
                ..standing(margin as f32)
            };
            let (scale, _) = speed_scale(along(asked as f32), 0.5, &moving, &BOUNDS);
            let scale = f64::from(scale);
            assert!(scale > 0.02 && scale < 0.98, "{margin}: {scale}");
            let keeps = |scale: f64| left_at_the_horizon(margin, own_decay, asked, scale) >= 0.05;
            let most = (0..=1_000)
                .rev()
                .map(|step| f64::from(step) * 1e-3)
                .find(|scale| keeps(*scale))
                .expect("nothing passed keeps the margin");
            // Of the decay that the command causes, the attribution misses 1 % at 0.2 m/s and 4 %
            // at 0.1 m/s, the slowest of these speeds.
            assert!(
                (scale - most).abs() < 0.02 * most + 2e-3,
                "{scale} of {most}"
            );
            assert!(
                keeps(0.98 * scale) && !keeps(1.02 * scale + 2e-3),
                "{scale}"
            );
        }
    }

    /// One edge at a time is narrow, and its decay would use it up within 50 ms.
    #[test]
    fn a_decaying_margin_refuses_every_motion_whichever_edge_it_is() {
        for edge in EDGES {
            for (forward, pitch) in MOTIONS {
                let mut margins = standing(0.3);
                margins.speed = forward;
                margins.now[edge as usize] = 0.011;
                margins.rate[edge as usize] = -0.22;
                let (scale, verdict) = speed_scale(along(forward), pitch, &margins, &BOUNDS);
                assert!(
                    scale < 0.25,
                    "{edge:?} at {forward} m/s, pitch {pitch}: {scale}"
                );
                let named = [Verdict::Scaled(edge), Verdict::Refused(edge)];
                assert!(named.contains(&verdict), "{verdict:?}");
            }
        }
    }

    /// Backs at -0.45 m/s with 11 mm to the rear edge, which shrink by 0.5 m/s.
    #[test]
    fn driving_backward_over_the_rear_edge_is_stopped() {
        let backing = Margins {
            rate: [-0.5, 0.0, 0.0, 0.0],
            speed: -0.45,
            ..standing(0.011)
        };
        for pitch in [-0.5, 0.0, 0.5] {
            let (scale, verdict) = speed_scale(along(-0.45), pitch, &backing, &BOUNDS);
            assert!(scale < 0.1, "{pitch}: {scale}");
            let named = [Verdict::Scaled(Edge::Back), Verdict::Refused(Edge::Back)];
            assert!(named.contains(&verdict), "{verdict:?}");
        }
    }

    #[test]
    fn an_edge_that_a_motion_leads_to_keeps_its_caution_band() {
        let narrow = |edge: Edge| {
            let mut margins = standing(0.3);
            (margins.now[2], margins.now[3]) = (0.3, 0.3);
            margins.now[edge as usize] = 0.04;
            margins
        };
        let refused = |forward, pitch, edge| {
            speed_scale(along(forward), pitch, &narrow(edge), &BOUNDS)
                == (0.0, Verdict::Refused(edge))
        };
        for (forward, pitch) in MOTIONS {
            for side in [Edge::Left, Edge::Right] {
                assert!(refused(forward, pitch, side), "{side:?} {forward} {pitch}");
            }
        }
        for (forward, pitch, edge) in [
            (0.3, 0.5, Edge::Back),
            (0.3, 0.0, Edge::Front),
            (0.3, -0.5, Edge::Front),
            (-0.3, 0.0, Edge::Back),
            (-0.3, -0.5, Edge::Back),
            (-0.3, -0.5, Edge::Front),
        ] {
            assert!(refused(forward, pitch, edge), "{edge:?} {forward} {pitch}");
        }
    }

    /// Tracks, with the bottom on a nose below the centre of gravity.
    const ON_A_NOSE: Bounds = Bounds {
        noses: true,
        ..BOUNDS
    };

    /// Pitch after the rear was pushed towards a nose, rad, in double precision: at `speed` for
    /// `steady` s, then more and more slowly until it stands after `stop` s. The nose is `ahead` of
    /// the rear (m) when the pitch is `pitch`, and stays where it is.
    fn pushed(pitch: f64, ahead: f64, speed: f64, [steady, stop]: [f64; 2]) -> f64 {
        const STEP: f64 = 1e-5;
        let nose = ahead * libm::tan(pitch);
        let (mut ahead, mut time) = (ahead, 0.0);
        while time < steady + stop && ahead > 0.0 {
            let slower = if time < steady {
                1.0
            } else {
                1.0 - (time - steady) / stop
            };
            ahead -= speed * slower * STEP;
            time += STEP;
        }
        libm::atan2(nose, ahead)
    }

    #[test]
    fn a_rear_that_is_pushed_towards_a_nose_turns_the_robot_about_it() {
        for pitch in [0.2, 0.6, 1.0] {
            for margin in [0.06, 0.15, 0.25] {
                for height in [0.1, 0.3] {
                    for (scale, stop) in [(0.1, 0.03), (0.5, 0.15), (1.0, 0.3)] {
                        let command = Command::new(0.45, 0.0);
                        let nose = ON_A_NOSE.nose(command, pitch).expect("a nose");
                        let found = nose.left(margin, height, scale);
                        let [pitch, margin, height, scale] =
                            [pitch, margin, height, scale].map(f64::from);
                        let turned = pushed(pitch, margin, 0.45 * scale, [0.15, stop]) - pitch;
                        let left = margin * libm::cos(turned) - height * libm::sin(turned);
                        assert!((f64::from(found) - left).abs() < 1e-3, "{pitch} {margin}");
                    }
                }
            }
        }
        let nose = |pitch| {
            ON_A_NOSE
                .nose(Command::new(0.45, 0.0), pitch)
                .expect("a nose")
        };
        // Upright, and no farther.
        for scale in [0.9, 1.0, f32::INFINITY] {
            let upright = 0.1 * libm::sinf(0.6) - 0.2 * libm::cosf(0.6);
            assert!((nose(0.6).left(0.1, 0.2, scale) - upright).abs() < 1e-6);
        }
        assert_eq!(nose(0.6).left(-0.1, 0.2, 1.0), -0.1);
        assert!(nose(0.6).left(f32::NAN, 0.2, 1.0).is_nan());
        assert!(nose(f32::NAN).left(0.1, 0.2, 1.0).is_nan());
        assert!(
            nose(core::f32::consts::FRAC_PI_2)
                .left(0.1, 0.2, 1.0)
                .is_finite()
        );
    }

    #[test]
    fn only_a_side_that_drives_forward_pitched_up_pushes_the_rear() {
        let pushes = |bounds: Bounds, forward, yaw_rate, pitch| {
            bounds
                .nose(Command::new(forward, yaw_rate), pitch)
                .is_some()
        };
        assert!(pushes(ON_A_NOSE, 0.3, 0.0, 0.6) && pushes(ON_A_NOSE, -0.1, 1.0, 0.6));
        assert!(!pushes(ON_A_NOSE, -0.3, 0.5, 0.6) && !pushes(BOUNDS, 0.3, 0.0, 0.6));
        assert!(!pushes(ON_A_NOSE, 0.3, 0.0, 0.0) && !pushes(ON_A_NOSE, 0.3, 0.0, -0.6));
    }

    /// A turn counts with its faster side, and never with more than a side can do. The nose fades
    /// in with the pitch.
    #[test]
    fn a_turn_on_a_nose_counts_as_its_faster_side_and_a_small_pitch_changes_little() {
        let left = |forward, yaw_rate, pitch| {
            let nose = ON_A_NOSE.nose(Command::new(forward, yaw_rate), pitch);
            nose.expect("a nose").left(0.15, 0.2, 1.0)
        };
        assert_eq!(left(0.0, 2.0, 0.6), left(0.3, 0.0, 0.6));
        assert_eq!(left(0.4, -2.0, 0.6), left(0.45, 0.0, 0.6));
        assert!(left(0.45, 0.0, 1e-3) > 0.1499);
        let scale = |pitch| speed_scale(along(0.45), pitch, &standing(0.1), &ON_A_NOSE).0;
        assert!((scale(1e-3) - scale(-1e-3)).abs() < 0.01);
    }

    /// Smallest margin of a robot that pushes its rear towards a nose and then stops, over all
    /// places of the nose from below the centre of gravity on. A robot whose centre of gravity gets
    /// ahead of the nose tips forward and is safe.
    fn least_margin(pitch: f32, margin: f32, height: f32, speed: f32) -> f64 {
        let [pitch, margin, height, speed] = [pitch, margin, height, speed].map(f64::from);
        let left = |ahead: f64| {
            let after = pushed(pitch, ahead, speed, [0.15, speed / 1.5]);
            let turned = after - pitch;
            let left = margin * libm::cos(turned) - height * libm::sin(turned);
            let nose = ahead * libm::tan(pitch) / libm::tan(after);
            if left > nose { margin } else { left }
        };
        (0..20)
            .map(|step| left(margin + 0.02 * f64::from(step)))
            .fold(margin, f64::min)
    }

    #[test]
    fn a_steep_robot_is_not_pushed_over_its_rear() {
        let mut slowed = 0;
        for pitch in [0.5, 0.7, 0.9, 1.0] {
            for margin in [0.08, 0.1, 0.13, 0.16, 0.2] {
                for height in [0.15, 0.2, 0.25, 0.3] {
                    let still = Tipping {
                        height,
                        gyration: 0.053,
                        ..Tipping::default()
                    };
                    let bounds = Bounds {
                        tipping: [still; 4],
                        ..ON_A_NOSE
                    };
                    let command = Command::new(0.45, 0.0);
                    let (scale, _) = speed_scale(command, pitch, &standing(margin), &bounds);
                    let left = |scale: f32| least_margin(pitch, margin, height, 0.45 * scale);
                    assert!(left(scale) > 0.049, "{pitch} {margin} {height}: {scale}");
                    slowed += usize::from(left(1.0) < 0.049);
                }
            }
        }
        assert!(slowed > 20, "{slowed}");
    }

    #[test]
    fn a_speed_limit_scales_what_is_above_it() {
        let passed = (1.0, Verdict::Passed);
        assert_eq!(within_limit(passed, -0.2, (0.3, Edge::Back)), passed);
        assert_eq!(within_limit(passed, 0.0, (0.0, Edge::Front)), passed);
        let (scale, verdict) = within_limit(passed, -0.4, (0.1, Edge::Back));
        assert!((scale - 0.25).abs() < 1e-6);
        assert_eq!(verdict, Verdict::Scaled(Edge::Back));
        let refused = (0.0, Verdict::Refused(Edge::Front));
        for limit in [0.0, f32::NAN] {
            assert_eq!(within_limit(passed, 0.4, (limit, Edge::Front)), refused);
        }
        assert_eq!(within_limit(passed, f32::NAN, (1.0, Edge::Front)), refused);
    }

    #[test]
    fn backing_down_from_a_narrow_margin_is_slow_but_goes_on() {
        let scale = |back| speed_scale(along(-0.1), 0.9, &standing(back), &BOUNDS).0;
        assert_eq!(scale(0.051), 1.0);
        assert!((scale(0.03) - 0.5).abs() < 1e-4);
        assert!(scale(0.012) > 0.0);
        assert_eq!(scale(0.009), 0.0);
    }

    /// While the robot backs down from a pitch of 81 degrees, a track slips. From 50 mm on, the
    /// margin falls by 0.2 to 1.5 m per metre driven. The passed speed follows the scale with
    /// 0.4 m/s^2, as a track does. The remaining margin must be enough for the momentum:
    /// `w^2 = 2 g (l - h) / l^2`, for a point mass at the height `h` and `l^2 = m^2 + h^2`, is the
    /// angular rate that tips the robot.
    #[test]
    fn a_retreat_that_goes_wrong_ends_with_little_momentum() {
        const STEP: f64 = 4e-3;
        let height = 0.27_f64;
        for per_metre in [0.2, 0.6, 1.5] {
            let (mut margin, mut speed, mut rate) = (0.05_f64, 0.0_f64, 0.0_f64);
            for _ in 0..2_500 {
                let margins = Margins {
                    rate: [rate as f32, 0.0, 0.0, 0.0],
                    speed: -speed as f32,
                    ..standing(margin as f32)
                };
                let (scale, _) = speed_scale(along(-0.5), 1.4, &margins, &BOUNDS);
                let goal = 0.5 * f64::from(scale);
                speed += (goal - speed).clamp(-0.4 * STEP, 0.4 * STEP);
                let decay = per_metre * speed;
                margin -= decay * STEP;
                // The guard smooths its rates over 100 ms.
                rate += (-decay - rate) * STEP / (0.1 + STEP);
                let reach = margin.hypot(height);
                let tips = (2.0 * 9.81 * (reach - height)).sqrt() / reach;
                assert!(
                    margin > 0.0 && decay / height < tips,
                    "{per_metre}: {margin} m, {decay} m/s"
                );
            }
            assert!(
                margin < 0.02,
                "{per_metre}: it stopped {margin} m before the edge"
            );
        }
    }

    #[test]
    fn margins_that_are_no_numbers_refuse() {
        for edge in 0..4 {
            let mut margins = standing(0.3);
            margins.now[edge] = f32::NAN;
            for (forward, pitch) in MOTIONS {
                assert_eq!(
                    speed_scale(along(forward), pitch, &margins, &BOUNDS).0,
                    0.0,
                    "edge {edge}"
                );
            }
        }
    }

    /// Nose up, 70 mm from the rear edge, with driving sides 0.15 m from the middle.
    #[test]
    fn turning_nose_up_is_held_back_at_the_rear_edge_like_driving_forward() {
        let turning = |forward: f32, yaw_rate: f32, pitch: f32| {
            let command = Command::new(forward, yaw_rate);
            speed_scale(command, pitch, &standing(0.07), &BOUNDS).0
        };
        for (forward, yaw_rate) in [(0.0, 0.5), (0.0, -0.5), (-0.05, 0.5), (0.05, 0.5)] {
            assert!((turning(forward, yaw_rate, 0.9) - 0.5).abs() < 1e-5);
            assert_eq!(turning(forward, yaw_rate, -0.1) < 1.0, forward < 0.0);
        }
        // The outer side drives forward at 10 mm/s, then stands, then drives backward.
        assert!((turning(-0.065, 0.5, 0.9) - 0.75).abs() < 1e-4);
        assert_eq!(turning(-0.076, 0.5, 0.9), 1.0);
        assert_eq!(turning(-0.2, 0.5, 0.9), 1.0);
        assert_eq!(turning(0.0, 0.0, 0.9), 1.0);
        assert_eq!(turning(0.0, f32::NAN, 0.9), 0.0);
    }

    #[test]
    fn turning_on_the_spot_does_not_chatter_about_level_ground() {
        let mut before = 1.0;
        for step in 0..2_000 {
            let pitch = -0.05 + step as f32 * 1e-4;
            let command = Command::new(0.0, 0.5);
            let (scale, _) = speed_scale(command, pitch, &standing(0.055), &BOUNDS);
            assert!((scale - before).abs() < 2e-3, "{pitch}: {before} {scale}");
            before = scale;
        }
        assert!((before - 0.125).abs() < 1e-5, "{before}");
    }

    /// A robot with its centre of gravity 0.2 m above the rear edge backs on level ground. The
    /// scale is the largest, in steps of 0.001, with which an instant stop leaves the margin of the
    /// ramp. The energies are those of a point mass, in double precision.
    #[test]
    fn an_instant_stop_from_what_passes_leaves_the_margin_of_the_ramp() {
        let height = 0.2_f64;
        let mut bounds = BOUNDS;
        bounds.tipping[Edge::Back as usize] = Tipping {
            height: height as f32,
            arm: height as f32,
            ..STILL
        };
        let rise = |margin: f64| margin.hypot(height) - height;
        for (margin, asked) in [(0.1_f64, 0.9), (0.12, 0.9), (0.2, 2.0)] {
            let (scale, verdict) =
                speed_scale(along(-asked as f32), 0.0, &standing(margin as f32), &bounds);
            assert_eq!(verdict, Verdict::Scaled(Edge::Back));
            let keeps = |scale: f64| {
                let rate = scale * asked * height / margin.hypot(height).powi(2);
                let energy = margin.hypot(height).powi(2) * rate * rate / (2.0 * 9.81);
                rise(margin) - energy >= rise(0.05 + 0.04 * scale)
            };
            let most = (0..=1_000)
                .rev()
                .map(|step| f64::from(step) * 1e-3)
                .find(|scale| keeps(*scale))
                .expect("at rest it keeps the margin");
            assert!(
                (f64::from(scale) - most).abs() < 5e-3,
                "{margin}: {scale} {most}"
            );
        }
    }

    /// At rest everything passes. At 3 rad/s the robot has more energy of rotation than it takes to
    /// tip it over.
    #[test]
    fn a_robot_that_rotates_toward_an_edge_has_less_left() {
        for edge in EDGES {
            let scale = |rate: f32| {
                let mut bounds = BOUNDS;
                bounds.tipping[edge as usize] = Tipping {
                    height: 0.25,
                    rate,
                    gyration: 0.05,
                    ..STILL
                };
                let mut margins = standing(0.3);
                margins.now = [0.3; 4];
                margins.now[edge as usize] = 0.12;
                speed_scale(along(0.01), 0.1, &margins, &bounds).0
            };
            assert_eq!((scale(0.0), scale(-2.0)), (1.0, 1.0), "{edge:?}");
            assert_eq!((scale(0.7), scale(3.0)), (1.0, 0.0), "{edge:?}");
        }
    }

    /// The left edge is as near in both directions, and falls by half a metre per metre driven.
    #[test]
    fn a_decay_is_attributed_to_the_command_forward_and_backward_alike() {
        let scale = |forward: f32, speed: f32| {
            let mut margins = standing(0.3);
            (margins.now[2], margins.rate[2]) = (0.12, -0.5 * speed.abs());
            margins.speed = speed;
            speed_scale(along(forward), 0.0, &margins, &BOUNDS)
        };
        for speed in [0.1_f32, 0.25, 0.4] {
            let (forward, verdict) = scale(0.4, speed);
            assert_eq!(scale(-0.4, -speed), (forward, verdict));
            // A robot that still moves the other way does not decay because of the command.
            assert_eq!(scale(-0.4, speed), scale(0.4, -speed));
            assert!(scale(-0.4, speed).0 != forward, "{speed}: {forward}");
        }
    }

    /// The left edge is near, and falls while the robot drives.
    #[test]
    fn a_turn_on_the_spot_counts_as_driving_forward() {
        for speed in [0.25, -0.25] {
            let scale = |forward: f32| {
                let mut margins = standing(0.3);
                (margins.now[2], margins.rate[2]) = (0.10, -0.125);
                margins.speed = speed;
                let command = Command::new(forward, 0.5);
                speed_scale(command, 0.0, &margins, &BOUNDS).0
            };
            assert!((scale(0.0) - scale(1e-6)).abs() < 1e-4, "{speed}");
            assert!((scale(0.0) - scale(-1e-6)).abs() > 0.3, "{speed}");
        }
    }

    #[test]
    fn a_finite_command_is_not_refused_however_large_it_is() {
        for (forward, yaw_rate) in [(1e30, 1e30), (3e38, -3e38), (-3e38, 3e38)] {
            let command = Command::new(forward, yaw_rate);
            let passed = speed_scale(command, 0.0, &standing(0.3), &BOUNDS);
            assert_eq!(passed, (1.0, Verdict::Passed));
        }
    }

    /// The scaled speed exceeds the limit by its last bit. The quotient of limit and speed is
    /// rounded, and may be as large as the scale or larger.
    #[test]
    fn a_speed_limit_never_raises_a_scale() {
        let passed = Verdict::Scaled(Edge::Left);
        let mut kept = 0;
        for step in 1..1_000 {
            let (scale, speed) = (step as f32 * 1e-3, 0.3 + step as f32 * 1e-4);
            let limit = (speed * scale).next_down();
            let (left, verdict) = within_limit((scale, passed), speed, (limit, Edge::Back));
            assert!(left <= scale, "{step}");
            if left == scale {
                assert_eq!(verdict, passed, "{step}");
                kept += 1;
            }
        }
        assert!(kept > 0);
    }

    #[test]
    fn a_refused_command_stays_refused_for_its_first_reason() {
        let refused = (0.0, Verdict::Refused(Edge::Back));
        for limit in [0.0, 0.1, 1.0] {
            assert_eq!(within_limit(refused, 0.4, (limit, Edge::Front)), refused);
        }
    }
}
