//! Scales a command down, between the operator's value and zero, so that every margin's decay
//! stays within bounds (a control-barrier filter). It never adds motion of its own.
//!
//! The barrier is `m - m_stop` for the margin `m` of each edge. With the scale `s` of the
//! commanded speed `u`, the margin decays with `dm/dt = r_0 + k s u`: `k u` is the part of the
//! measured rate that the command causes, `r_0` the rest. Within the stopping horizon `T` (the
//! time until a stop begins, and the time that it takes) this must hold:
//!
//! `dm/dt >= -gamma (m - m_stop - s w)`, `gamma = 1/T`,
//!
//! `w` being the caution band `m_caution - m_stop`: the more of a command passes, the earlier a
//! margin counts as used up. Hence `s = (m - m_stop + r_0 T) / (w + |k u| T)`, limited to 0 to 1.
//!
//! All four edges are watched in every motion. A motion that leads away from an edge ([`leads_to`]),
//! such as backing down from a nose, has no caution band there. It gets slower between the stop margin
//! and the trip margin, and it ends while the margin decays so that the trip margin would be reached
//! within the horizon: when a track slips or the ground ends, little momentum may be left.

use super::support::{EDGES, Edge};
use crate::math::{clamp, max, min};

pub use super::tracker::{Margins, Tracker};
pub use super::verdict::Verdict;

/// Speed at which half of a margin's rate is put down to the command, m/s; below, noise is most of it.
const ATTRIBUTION_SPEED: f32 = 0.02;

/// Speed, m/s, and pitch nose up, rad, from which on the outer side of a turning robot counts as one
/// that drives forward and lifts the front.
const LIFTING_SPEED: f32 = 0.02;
const LIFTING_PITCH: f32 = 0.1;

/// A smaller share of a posture's speed is called none.
pub(super) const SMALLEST_SHARE: f32 = 0.05;

/// Motion over ground that is asked for or passed.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct SpeedCommand {
    /// Forward speed, m/s.
    pub forward: f32,
    /// Yaw rate, counter-clockwise from above, rad/s.
    pub yaw_rate: f32,
}

/// Margins between which the share that passes grows from nothing to all, m.
#[derive(Clone, Copy, Debug)]
pub struct Ramp {
    /// At and below this margin nothing passes.
    pub none: f32,
    /// At and above this margin, while it does not decay, all passes.
    pub all: f32,
}

impl Ramp {
    /// Distance of the two, m, above zero. Margins are tens of millimetres; the least keeps divisions
    /// away from zero.
    pub fn width(self) -> f32 {
        let width = self.all - self.none;
        if width > 1e-3 { width } else { 1e-3 }
    }

    /// The same at margins that are wider by `reserve`, m.
    #[must_use]
    pub fn moved(self, reserve: f32) -> Self {
        Self {
            none: self.none + reserve,
            all: self.all + reserve,
        }
    }

    /// Share that a margin leaves, 0 to 1; 0 for NaN.
    pub fn share(self, margin: f32) -> f32 {
        share((margin - self.none) / self.width())
    }
}

/// Bounds of the filter.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Of an edge that a motion leads to.
    pub towards: Ramp,
    /// Of an edge from which it leads away.
    pub away: Ramp,
    /// How far ahead decay counts, s: `1 / gamma`.
    pub horizon: f32,
    /// The same for posture motions: how far ahead the shape is that they lead to, s.
    pub foresight: f32,
    /// What driving keeps at the rear edge for the sway of a body that is lifted, m.
    pub reserve: f32,
    /// Distance of the driving sides from the middle, m, of a robot that turns by their speeds.
    pub half_width: f32,
}

impl Bounds {
    /// How much the outer side of a turning robot lifts the front of the robot by driving forward:
    /// from 0 to 1 at [`LIFTING_SPEED`] and [`LIFTING_PITCH`].
    fn lifts(&self, command: SpeedCommand, pitch: f32) -> f32 {
        let outer = command.forward + self.half_width * command.yaw_rate.abs();
        share(outer / LIFTING_SPEED) * share(pitch / LIFTING_PITCH)
    }
}

/// Whether a command with this forward speed, at this pitch, can use up the margin to an edge by
/// itself. Every edge for NaN.
///
/// Back: driving forward nose up (what lifts the front goes on doing so), and driving backward on
/// level ground or nose down. Front: driving forward or backward on level ground or nose down. Left
/// and right: always. The other motions lead away from the edge. They can still use up its margin
/// when the ground ends or when they stop: the decay of the margin and the speed limit of
/// [`super::stopping`] are watched then.
fn leads_to(edge: Edge, forward: f32, pitch: f32) -> bool {
    match edge {
        Edge::Back if forward > 0.0 => !(pitch <= 0.0),
        Edge::Back => !(forward == 0.0 || pitch > 0.0),
        Edge::Front => !(pitch > 0.0),
        Edge::Left | Edge::Right => true,
    }
}

/// Scale of the commanded speed, 0 to 1, and the verdict. What is not finite refuses.
///
/// Nose up, an outer side that drives forward in a turn lifts the front on a nose. Then the rear edge
/// counts as in driving forward ([`Bounds::lifts`]). A lifted body keeps [`Bounds::reserve`] there.
pub fn drive(
    command: SpeedCommand,
    pitch: f32,
    margins: &Margins,
    bounds: &Bounds,
) -> (f32, Verdict) {
    let forward = command.forward;
    if !(forward + command.yaw_rate).is_finite() {
        return (0.0, Verdict::Refused(Edge::Back));
    }
    let lifts = bounds.lifts(command, pitch);
    let (mut share, mut verdict) = (1.0, Verdict::Passed);
    for edge in EDGES {
        let index = edge as usize;
        let (towards, lifts) = if edge == Edge::Back {
            (bounds.towards.moved(bounds.reserve), lifts)
        } else {
            (bounds.towards, 0.0)
        };
        let kept = || passable(forward, index, margins, towards, bounds.horizon);
        let left = if leads_to(edge, forward, pitch) {
            kept()
        } else {
            let end = Ramp {
                none: bounds.away.none,
                all: bounds.away.none,
            };
            let slow = bounds.away.share(margins.now[index]);
            let away = min(slow, passable(forward, index, margins, end, bounds.horizon));
            if lifts > 0.0 {
                min(away, 1.0 - lifts * (1.0 - kept()))
            } else {
                away
            }
        };
        if left < share {
            share = left;
            verdict = if left > 0.0 {
                Verdict::Scaled(edge)
            } else {
                Verdict::Refused(edge)
            };
        }
    }
    (share, verdict)
}

/// Lowers a scale so that the scaled speed stays within the `limit` (m/s) of an edge.
pub fn within_speed(
    (share, verdict): (f32, Verdict),
    forward: f32,
    (limit, edge): (f32, Edge),
) -> (f32, Verdict) {
    let speed = forward.abs();
    if speed * share <= limit {
        return (share, verdict);
    }
    let left = limit / speed;
    // The first is false for NaN.
    match left > 0.0 {
        true if left < share => (left, Verdict::Scaled(edge)),
        true => (share, verdict),
        false => (0.0, Verdict::Refused(edge)),
    }
}

/// Scale that one edge leaves, always 0 to 1.
fn passable(forward: f32, index: usize, margins: &Margins, ramp: Ramp, horizon: f32) -> f32 {
    // Growth is not counted on.
    let rate = min(margins.rate[index], 0.0);
    // Speed in the direction of the command.
    let along = if forward < 0.0 {
        -margins.speed
    } else {
        margins.speed
    };
    let along = if along > 0.0 { along } else { 0.0 };
    // Least squares for rate = k speed, leaning to zero where the speed says nothing.
    let per_speed = -rate * along / (along * along + ATTRIBUTION_SPEED * ATTRIBUTION_SPEED);
    let rest = rate + per_speed * along;
    let room = margins.now[index] - ramp.none + rest * horizon;
    share(room / (ramp.width() + per_speed * forward.abs() * horizon))
}

/// Slower decay is noise, m/s.
const STEADY: f32 = 0.01;

/// Share that a posture motion keeps at an edge whose margin it widens, however narrow it is: it may
/// lead out of danger.
const RESCUE: f32 = 0.1;

/// Pitch from which on the whole caution band is kept for sway, rad.
const STEEP: f32 = 0.5;

/// Share of the caution band that is kept for sway toward an edge at this pitch: nose up to the back,
/// nose down to the front. NaN for NaN.
pub fn sway(edge: Edge, pitch: f32) -> f32 {
    match edge {
        Edge::Back => clamp(pitch / STEEP, 0.0, 1.0),
        Edge::Front => clamp(-pitch / STEEP, 0.0, 1.0),
        Edge::Left | Edge::Right => 0.0,
    }
}

/// Limited to 0 to 1. Zero for NaN.
fn share(quotient: f32) -> f32 {
    let share = clamp(quotient, 0.0, 1.0);
    if share >= 0.0 { share } else { 0.0 }
}

/// Scale of a posture's speed, 0 to 1, and the verdict. `ahead` are the margins of the shape that
/// the motion leads to within the horizon, at the present pitch.
///
/// The pitch does not stay: a front that meets the ground lifts the body. So the measured decay is
/// added to what the shape says. A motion that narrows a margin by this account slows down through the
/// caution band and ends at the stop margin. A steep robot on a nose also sways when its centre of
/// gravity moves, and keeps the whole caution band for that. A motion that widens a margin is slow only
/// below the stop margin, and it never ends: [`RESCUE`]. NaN refuses.
pub fn posture(pitch: f32, margins: &Margins, ahead: [f32; 4], bounds: &Bounds) -> (f32, Verdict) {
    let (mut least, mut verdict) = (1.0, Verdict::Passed);
    for edge in EDGES {
        let index = edge as usize;
        let (now, then) = (margins.now[index], ahead[index]);
        let rate = margins.rate[index];
        let decay = if rate < -STEADY {
            rate * bounds.foresight
        } else {
            0.0
        };
        let mut part = if then + decay >= now {
            bounds.away.share(now)
        } else {
            let reserve = sway(edge, pitch) * bounds.towards.width();
            // Below the present margin anyway, unless that is NaN.
            bounds.towards.share(min(then + decay - reserve, now))
        };
        if then >= now {
            part = max(part, RESCUE);
        }
        if part < least {
            least = part;
            verdict = if part >= SMALLEST_SHARE {
                Verdict::PostureScaled(edge)
            } else {
                Verdict::PostureRefused(edge)
            };
        }
    }
    (least, verdict)
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ramp(none: f32, all: f32) -> Ramp {
        Ramp { none, all }
    }

    const BOUNDS: Bounds = Bounds {
        towards: ramp(0.05, 0.09),
        away: ramp(0.01, 0.05),
        horizon: 0.25,
        foresight: 0.15,
        reserve: 0.0,
        half_width: 0.15,
    };

    fn along(forward: f32) -> SpeedCommand {
        SpeedCommand {
            forward,
            yaw_rate: 0.0,
        }
    }

    fn standing(back: f32) -> Margins {
        Margins {
            now: [back, 0.3, 0.15, 0.15],
            rate: [0.0; 4],
            speed: 0.0,
        }
    }

    #[test]
    fn the_share_falls_from_all_to_nothing_through_the_caution_band() {
        assert_eq!(
            drive(along(0.13), 0.5, &standing(0.10), &BOUNDS),
            (1.0, Verdict::Passed)
        );
        let (share, verdict) = drive(along(0.13), 0.5, &standing(0.07), &BOUNDS);
        assert!((share - 0.5).abs() < 1e-5);
        assert_eq!(verdict, Verdict::Scaled(Edge::Back));
        assert_eq!(
            drive(along(0.13), 0.5, &standing(0.04), &BOUNDS),
            (0.0, Verdict::Refused(Edge::Back))
        );
    }

    #[test]
    fn a_decay_that_the_command_does_not_answer_for_counts_as_what_it_leaves() {
        let falling = Margins {
            rate: [-0.4, 0.0, 0.0, 0.0],
            ..standing(0.14)
        };
        // 140 mm - 0.4 m/s for 0.25 s: below the stop margin.
        assert_eq!(
            drive(along(0.13), 0.5, &falling, &BOUNDS),
            (0.0, Verdict::Refused(Edge::Back))
        );
    }

    /// Forward speed and pitch of every kind of motion.
    const MOTIONS: [(f32, f32); 7] = [
        (0.3, 0.5),
        (0.3, 0.0),
        (0.3, -0.5),
        (-0.3, 0.5),
        (-0.3, 0.0),
        (-0.3, -0.5),
        (0.0, 0.5),
    ];

    /// Follows the margin of an edge in double precision, in steps of 0.1 ms, while the robot drives
    /// with the speed `scale u`: the margin falls by 1 m per metre driven, beside a decay of its
    /// own. What may be used up within the horizon is the room above the stop margin and the part
    /// of the caution band that belongs to the scale.
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

    /// The scale is found by brute force as well: the largest of 1000 with which the margin is not
    /// below the stop margin at the horizon.
    #[test]
    fn what_passes_is_the_most_that_does_not_cross_the_stop_margin_within_the_horizon() {
        for (margin, asked, driven, own_decay) in [
            (0.12, 0.2, 0.2, 0.0),
            (0.10, 0.4, 0.3, 0.0),
            (0.08, 0.1, 0.1, 0.0),
            (0.07, 0.45, 0.2, 0.0),
            (0.09, 0.45, 0.45, 0.0),
            // At rest nothing of it is caused by the command, whose own effect is not known yet.
            (0.09, 1e-6, 0.0, 0.1),
        ] {
            // The measured decay is that of a robot that drove at `driven`.
            let moving = Margins {
                rate: [-(driven + own_decay) as f32, 0.0, 0.0, 0.0],
                speed: driven as f32,
                ..standing(margin as f32)
            };
            let (scale, _) = drive(along(asked as f32), 0.5, &moving, &BOUNDS);
            let scale = f64::from(scale);
            assert!(scale > 0.02 && scale < 0.98, "{margin}: {scale}");
            let keeps = |scale: f64| left_at_the_horizon(margin, own_decay, asked, scale) >= 0.05;
            let most = (0..=1_000)
                .rev()
                .map(|step| f64::from(step) * 1e-3)
                .find(|scale| keeps(*scale))
                .expect("nothing passed keeps the margin");
            // A hundredth of the decay counts as not caused by the command at the slowest of these
            // speeds: 4 % of it at 0.1 m/s.
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

    /// One edge at a time is narrow and decays as if it were used up within 50 ms.
    #[test]
    fn a_decaying_margin_refuses_every_motion_whichever_edge_it_is() {
        for edge in EDGES {
            for (forward, pitch) in MOTIONS {
                let mut margins = standing(0.3);
                margins.speed = forward;
                margins.now[edge as usize] = 0.011;
                margins.rate[edge as usize] = -0.22;
                let (share, verdict) = drive(along(forward), pitch, &margins, &BOUNDS);
                assert!(
                    share < 0.25,
                    "{edge:?} at {forward} m/s, pitch {pitch}: {share}"
                );
                let named = [Verdict::Scaled(edge), Verdict::Refused(edge)];
                assert!(named.contains(&verdict), "{verdict:?}");
            }
        }
    }

    /// The case of a review: -0.45 m/s, 11 mm behind, shrinking with 0.5 m/s.
    #[test]
    fn driving_backward_over_the_rear_edge_is_stopped() {
        let backing = Margins {
            rate: [-0.5, 0.0, 0.0, 0.0],
            speed: -0.45,
            ..standing(0.011)
        };
        for pitch in [-0.5, 0.0, 0.5] {
            let (share, verdict) = drive(along(-0.45), pitch, &backing, &BOUNDS);
            assert!(share < 0.1, "{pitch}: {share}");
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
            drive(along(forward), pitch, &narrow(edge), &BOUNDS) == (0.0, Verdict::Refused(edge))
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

    #[test]
    fn a_speed_limit_scales_what_is_above_it() {
        let passed = (1.0, Verdict::Passed);
        assert_eq!(within_speed(passed, -0.2, (0.3, Edge::Back)), passed);
        assert_eq!(within_speed(passed, 0.0, (0.0, Edge::Front)), passed);
        let (share, verdict) = within_speed(passed, -0.4, (0.1, Edge::Back));
        assert!((share - 0.25).abs() < 1e-6);
        assert_eq!(verdict, Verdict::Scaled(Edge::Back));
        let refused = (0.0, Verdict::Refused(Edge::Front));
        for limit in [0.0, f32::NAN] {
            assert_eq!(within_speed(passed, 0.4, (limit, Edge::Front)), refused);
        }
        assert_eq!(within_speed(passed, f32::NAN, (1.0, Edge::Front)), refused);
    }

    #[test]
    fn a_posture_motion_is_refused_at_any_edge() {
        for edge in EDGES {
            let now = standing(0.3);
            let mut ahead = now.now;
            ahead[edge as usize] = 0.04;
            let refused = (0.0, Verdict::PostureRefused(edge));
            assert_eq!(posture(0.0, &now, ahead, &BOUNDS), refused);
            ahead[edge as usize] = f32::NAN;
            assert_eq!(posture(0.0, &now, ahead, &BOUNDS), refused);
            let mut unknown = now;
            unknown.now[edge as usize] = f32::NAN;
            assert_eq!(posture(0.0, &unknown, now.now, &BOUNDS), refused);
        }
        let level = standing(0.3);
        let narrower = level.now.map(|margin| margin - 1e-3);
        assert_eq!(posture(f32::NAN, &level, narrower, &BOUNDS).0, 0.0);
    }

    /// Margins where the back is `back` m wide.
    fn ahead(back: f32) -> [f32; 4] {
        [back, 0.3, 0.15, 0.15]
    }

    #[test]
    fn a_posture_motion_that_narrows_a_margin_slows_down_before_it_is_refused() {
        let now = standing(0.14);
        let posture = |back| posture(0.0, &now, ahead(back), &BOUNDS);
        assert_eq!(posture(0.091), (1.0, Verdict::Passed));
        let (share, verdict) = posture(0.06);
        assert!((share - 0.25).abs() < 1e-4, "{share}");
        assert_eq!(verdict, Verdict::PostureScaled(Edge::Back));
        let refused = (0.0, Verdict::PostureRefused(Edge::Back));
        assert_eq!(posture(0.049), refused);
        assert_eq!(posture(f32::NAN), refused);
    }

    /// At half a radian the motion ends where the caution band begins; half as steep, in its middle.
    #[test]
    fn a_steep_robot_keeps_the_caution_band_for_its_sway() {
        let now = Margins {
            now: [0.2; 4],
            ..standing(0.2)
        };
        let narrowing = |edge: Edge, margin| {
            let mut ahead = now.now;
            ahead[edge as usize] = margin;
            ahead
        };
        for (edge, pitch) in [(Edge::Back, 0.5), (Edge::Front, -0.5)] {
            let share =
                |pitch: f32, margin| posture(pitch, &now, narrowing(edge, margin), &BOUNDS).0;
            for (pitch, end) in [
                (-pitch, 0.05),
                (0.0, 0.05),
                (0.5 * pitch, 0.07),
                (pitch, 0.09),
                (2.0 * pitch, 0.09),
            ] {
                assert_eq!(share(pitch, end - 1e-3), 0.0, "{edge:?} {pitch}");
                let half = share(pitch, end + 0.02);
                assert!((half - 0.5).abs() < 1e-4, "{edge:?} {pitch}: {half}");
                assert_eq!(share(pitch, end + 0.041), 1.0, "{edge:?} {pitch}");
            }
        }
        for edge in [Edge::Left, Edge::Right] {
            for pitch in [-1.0, 1.0] {
                let (share, _) = posture(pitch, &now, narrowing(edge, 0.07), &BOUNDS);
                assert!((share - 0.5).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn a_posture_motion_that_widens_a_narrow_margin_is_slow_but_goes_on() {
        let share = |now: f32| posture(1.0, &standing(now), ahead(now + 0.01), &BOUNDS).0;
        assert_eq!(share(0.051), 1.0);
        assert!((share(0.03) - 0.5).abs() < 1e-4);
        assert!((share(0.012) - RESCUE).abs() < 1e-6);
        assert!((share(-0.01) - RESCUE).abs() < 1e-6);
    }

    /// The margin falls with 0.2 m/s: 30 mm until the horizon, beside the change that the shape foresees.
    #[test]
    fn decay_adds_to_what_the_shape_does_to_a_margin_whichever_edge_it_is() {
        for edge in EDGES {
            let posture = |margin: f32, change: f32| {
                let mut margins = standing(0.3);
                margins.now = [0.3; 4];
                margins.now[edge as usize] = margin;
                margins.rate[edge as usize] = -0.2;
                posture(0.0, &margins, margins.now.map(|now| now + change), &BOUNDS)
            };
            for change in [-0.02, 0.02] {
                let left = |share: f32| 0.05 + 0.04 * share + 0.03 - change;
                assert_eq!(posture(left(1.01), change), (1.0, Verdict::Passed));
                assert!((posture(left(0.5), change).0 - 0.5).abs() < 1e-4);
            }
            assert_eq!(posture(0.09, -0.02), (0.0, Verdict::PostureRefused(edge)));
            let (rescued, verdict) = posture(0.05, 0.02);
            assert!((rescued - RESCUE).abs() < 1e-6);
            assert_eq!(verdict, Verdict::PostureScaled(edge));
        }
    }

    #[test]
    fn backing_down_from_a_narrow_margin_is_slow_but_goes_on() {
        let share = |back| drive(along(-0.1), 0.9, &standing(back), &BOUNDS).0;
        assert_eq!(share(0.051), 1.0);
        assert!((share(0.03) - 0.5).abs() < 1e-4);
        assert!(share(0.012) > 0.0);
        assert_eq!(share(0.009), 0.0);
    }

    /// Backing down from 81 degrees, a track slips: the margin falls with 0.6 m per metre driven, from
    /// 50 mm on. The passed speed follows the share with 0.4 m/s^2, as a track does. The margin that
    /// is left bears the momentum: `w^2 = 2 g (l - h) / l^2` for a mass point at the height `h`,
    /// `l^2 = m^2 + h^2`, is the rate of turn that tips the robot.
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
                let (share, _) = drive(along(-0.5), 1.4, &margins, &BOUNDS);
                let goal = 0.5 * f64::from(share);
                speed += (goal - speed).clamp(-0.4 * STEP, 0.4 * STEP);
                let decay = per_metre * speed;
                margin -= decay * STEP;
                // The guard's rates are smoothed over 100 ms.
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
                    drive(along(forward), pitch, &margins, &BOUNDS).0,
                    0.0,
                    "edge {edge}"
                );
            }
        }
    }

    /// Nose up at 70 mm from the rear edge, with sides 0.15 m from the middle.
    #[test]
    fn turning_nose_up_is_held_back_at_the_rear_edge_like_driving_forward() {
        let turning = |forward: f32, yaw_rate: f32, pitch: f32| {
            let command = SpeedCommand { forward, yaw_rate };
            drive(command, pitch, &standing(0.07), &BOUNDS).0
        };
        for (forward, yaw_rate) in [(0.0, 0.5), (0.0, -0.5), (-0.05, 0.5), (0.05, 0.5)] {
            assert!((turning(forward, yaw_rate, 0.9) - 0.5).abs() < 1e-5);
            assert_eq!(turning(forward, yaw_rate, -0.1) < 1.0, forward < 0.0);
        }
        // The outer side goes forward with 10 mm/s; it stands; it goes backward, too.
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
            let command = SpeedCommand {
                forward: 0.0,
                yaw_rate: 0.5,
            };
            let (share, _) = drive(command, pitch, &standing(0.055), &BOUNDS);
            assert!((share - before).abs() < 2e-3, "{pitch}: {before} {share}");
            before = share;
        }
        assert!((before - 0.125).abs() < 1e-5, "{before}");
    }

    /// 100 mm are beyond the caution band, and 10 of 40 mm into the band that ends at 90 mm. The front
    /// edge has no reserve.
    #[test]
    fn a_reserve_is_kept_at_the_rear_edge_while_driving() {
        let reserved = Bounds {
            reserve: 0.04,
            ..BOUNDS
        };
        let share =
            |pitch: f32, bounds: &Bounds| drive(along(0.2), pitch, &standing(0.1), bounds).0;
        assert_eq!(share(0.9, &BOUNDS), 1.0);
        assert!((share(0.9, &reserved) - 0.25).abs() < 1e-5);
        let mut front = standing(0.3);
        front.now[Edge::Front as usize] = 0.07;
        for bounds in [&BOUNDS, &reserved] {
            let (share, _) = drive(along(0.2), -0.5, &front, bounds);
            assert!((share - 0.5).abs() < 1e-5);
        }
    }
}
