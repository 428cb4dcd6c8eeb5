//! What the guard leaves of a command: the value closest to the operator's, between zero and what was asked, that keeps every margin's decay
//! within bounds (a control-barrier filter). It never adds motion of its own.
//!
//! The barrier is `m - m_stop` for the margin `m` of each edge at risk. With a share `s` of the asked speed `u` passed, the margin decays
//! with `dm/dt = r_0 + k s u`: `k u` is the part of the measured rate that the command answers for, `r_0` the rest. Within the stopping horizon `T`
//! (the time until a stop begins, and that it takes) this must hold:
//!
//! `dm/dt >= -gamma (m - m_stop - s w)`, `gamma = 1/T`,
//!
//! `w` being the caution band `m_caution - m_stop`: the more of a command passes, the earlier a margin counts as used up. Hence
//! `s = (m - m_stop + r_0 T) / (w + |k u| T)`, limited to 0 to 1.

use super::criterion::Evaluation;
use super::support::{EDGES, Edge, Stance};
use super::trust::Reason;
use crate::math::{clamp, min};

/// Speed at which half of a margin's rate is put down to the command, m/s; below, noise is most of it.
const ATTRIBUTION_SPEED: f32 = 0.02;

/// A smaller share of a posture's speed is called none.
const SMALLEST_SHARE: f32 = 0.05;

/// Motion over ground that is asked for or passed.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Command {
    /// Forward speed, m/s.
    pub forward: f32,
    /// Yaw rate, counter-clockwise from above, rad/s.
    pub yaw_rate: f32,
}

/// Bounds of the filter, m and s.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Below this margin, its decay within the horizon taken off, a command is scaled.
    pub caution: f32,
    /// At and below this margin a command is refused; below [`Self::caution`].
    pub stop: f32,
    /// How far ahead decay counts: `1 / gamma`.
    pub horizon: f32,
}

impl Bounds {
    /// Width of the caution band. Margins are tens of millimetres; the least keeps divisions away from zero.
    fn band(&self) -> f32 {
        let band = self.caution - self.stop;
        if band > 1e-3 { band } else { 1e-3 }
    }
}

/// What became of a command, and because of which edge.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Verdict {
    /// Passed as asked.
    #[default]
    Passed,
    /// A share of the asked speed passed.
    Scaled(Edge),
    /// Nothing of the asked speed passed.
    Refused(Edge),
    /// The posture is held where it is.
    PostureRefused(Edge),
    /// Nothing passed: how the robot stands is not known.
    Blind(Reason),
    /// Nothing passed: no operator was heard in time, or the dead-man switch is not held.
    Unattended,
    /// Nothing passed: the guard has tripped.
    Tripped(Edge),
    /// The guard has tripped, and the operator's supervised override passes at crawl speed.
    Overridden(Edge),
    /// The guard has tripped and backs off at crawl speed, as asked.
    BackingOff(Edge),
    /// Crawl speed passed: the sensors on the body are in doubt.
    Doubted(Reason),
    /// A share of the posture motion passed.
    PostureScaled(Edge),
    /// Nothing passed: the emergency stop was actuated and not reset.
    EmergencyStopped,
}

impl Verdict {
    /// Code in object 0x4001:2: kind in the high half, edge or reason in the low half.
    pub fn code(self) -> u8 {
        match self {
            Self::Passed => 0x00,
            Self::Scaled(edge) => 0x10 | edge as u8,
            Self::Refused(edge) => 0x20 | edge as u8,
            Self::PostureRefused(edge) => 0x30 | edge as u8,
            Self::Blind(reason) => 0x40 | reason as u8,
            Self::Unattended => 0x50,
            Self::Tripped(edge) => 0x60 | edge as u8,
            Self::Overridden(edge) => 0x70 | edge as u8,
            Self::BackingOff(edge) => 0x80 | edge as u8,
            Self::Doubted(reason) => 0x90 | reason as u8,
            Self::PostureScaled(edge) => 0xa0 | edge as u8,
            Self::EmergencyStopped => 0xb0,
        }
    }

    /// The verdict with this code.
    pub fn from_code(code: u8) -> Option<Self> {
        let low = code & 0x0f;
        if let (4 | 9, Some(reason)) = (code >> 4, Reason::from_byte(low)) {
            let doubted = code >> 4 == 9;
            return Some(if doubted {
                Self::Doubted(reason)
            } else {
                Self::Blind(reason)
            });
        }
        let edge = *EDGES.get(usize::from(low))?;
        Some(match code >> 4 {
            0 => Self::Passed,
            1 => Self::Scaled(edge),
            2 => Self::Refused(edge),
            3 => Self::PostureRefused(edge),
            5 => Self::Unattended,
            6 => Self::Tripped(edge),
            7 => Self::Overridden(edge),
            8 => Self::BackingOff(edge),
            10 => Self::PostureScaled(edge),
            11 => Self::EmergencyStopped,
            _ => return None,
        })
    }
}

/// Margins with their rates, and the speed with which they came about.
#[derive(Clone, Copy, Debug, Default)]
pub struct Margins {
    /// m, indexed by [`Edge`].
    pub now: [f32; 4],
    /// m/s.
    pub rate: [f32; 4],
    /// Forward speed, as late as the rates are, m/s.
    pub speed: f32,
}

/// Tracks margins and their rates from one evaluation to the next.
#[derive(Clone, Debug, Default)]
pub struct Tracker {
    /// Margins of the centre of gravity at the evaluation before, with rates and speed.
    before: Option<Margins>,
    standing: [bool; 4],
}

impl Tracker {
    /// Time in which rates and speed follow, s: a single sample moves them little.
    const RATE_TIME: f32 = 0.1;

    /// Takes the margins of a stance `period` s after the evaluation before, and the forward speed that was passed on, m/s.
    ///
    /// Rates are those of the centre of gravity alone: the measured force counts by how far it has moved a margin, but it comes and goes with every bump. They
    /// begin anew when other wheels stand than before. A rate from or to a margin that is no number is zero: it does not outlive it.
    #[inline(never)]
    pub fn update(
        &mut self,
        stance: &Stance,
        found: &Evaluation,
        speed: f32,
        period: f32,
    ) -> Margins {
        let share = period / (Self::RATE_TIME + period);
        let standing = stance.standing();
        let same = self.standing == standing;
        self.standing = standing;
        let before = self.before.filter(|_| same).unwrap_or(Margins {
            now: found.gravity,
            rate: [0.0; 4],
            speed,
        });
        let mut rate = before.rate;
        for (index, rate) in rate.iter_mut().enumerate() {
            let slope = (found.gravity[index] - before.now[index]) / period;
            let next = *rate + (slope - *rate) * share;
            *rate = if next.is_finite() { next } else { 0.0 };
        }
        let gravity = Margins {
            now: found.gravity,
            rate,
            speed: before.speed + (speed - before.speed) * share,
        };
        self.before = Some(gravity);
        Margins {
            now: found.margins,
            ..gravity
        }
    }
}

/// The edges over which a robot with this forward command and pitch could be driven.
///
/// Driving forward up a slope lifts the front: the rear edge counts. Driving forward on level ground or downward, the
/// front edge; backward, mirrored. The sides always count.
fn edges_at_risk(forward: f32, pitch: f32) -> [Option<Edge>; 3] {
    let end = match (forward > 0.0, pitch > 0.0) {
        (true, true) => Some(Edge::Back),
        (true | false, false) => Some(Edge::Front),
        // Backward and nose up: the robot comes down again.
        (false, true) => None,
    };
    [end, Some(Edge::Left), Some(Edge::Right)]
}

/// Share of the asked speed that may pass, 0 to 1, and the verdict. A margin that is no number refuses.
pub fn drive(forward: f32, pitch: f32, margins: &Margins, bounds: &Bounds) -> (f32, Verdict) {
    let (mut share, mut verdict) = (1.0, Verdict::Passed);
    for edge in edges_at_risk(forward, pitch).into_iter().flatten() {
        let left = passable(forward, edge as usize, margins, bounds);
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

/// Share that one edge leaves, always 0 to 1.
fn passable(forward: f32, index: usize, margins: &Margins, bounds: &Bounds) -> f32 {
    // Growth is not counted on.
    let rate = min(margins.rate[index], 0.0);
    // Speed in the direction that is asked for.
    let along = if forward < 0.0 {
        -margins.speed
    } else {
        margins.speed
    };
    let along = if along > 0.0 { along } else { 0.0 };
    // Least squares for rate = k speed, leaning to zero where the speed says nothing.
    let per_speed = -rate * along / (along * along + ATTRIBUTION_SPEED * ATTRIBUTION_SPEED);
    let rest = rate + per_speed * along;
    let room = margins.now[index] - bounds.stop + rest * bounds.horizon;
    let share = clamp(
        room / (bounds.band() + per_speed * forward.abs() * bounds.horizon),
        0.0,
        1.0,
    );
    // False for NaN.
    if share >= 0.0 { share } else { 0.0 }
}

/// Share of a posture's speed that may pass, 0 to 1, and the verdict. `ahead` are the margins of the shape that it leads to within the horizon.
///
/// What leads to more than now passes. Otherwise the speed falls to nothing over the last quarter of the caution band, so that the motion comes to rest
/// at the stop margin without hunting. A margin that is no number refuses.
pub fn posture(margins: &Margins, ahead: [f32; 4], bounds: &Bounds) -> (f32, Verdict) {
    let slowing = 0.25 * bounds.band();
    let (mut share, mut verdict) = (1.0, Verdict::Passed);
    for edge in [Edge::Back, Edge::Left, Edge::Right] {
        let (now, then) = (margins.now[edge as usize], ahead[edge as usize]);
        let part = if then >= now {
            1.0
        } else {
            clamp((then - bounds.stop) / slowing, 0.0, 1.0)
        };
        // False for NaN.
        let part = if part >= 0.0 { part } else { 0.0 };
        if part < share {
            share = part;
            verdict = if part >= SMALLEST_SHARE {
                Verdict::PostureScaled(edge)
            } else {
                Verdict::PostureRefused(edge)
            };
        }
    }
    (share, verdict)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Bounds = Bounds {
        caution: 0.09,
        stop: 0.05,
        horizon: 0.25,
    };

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
            drive(0.13, 0.5, &standing(0.10), &BOUNDS),
            (1.0, Verdict::Passed)
        );
        let (share, verdict) = drive(0.13, 0.5, &standing(0.07), &BOUNDS);
        assert!((share - 0.5).abs() < 1e-5);
        assert_eq!(verdict, Verdict::Scaled(Edge::Back));
        assert_eq!(
            drive(0.13, 0.5, &standing(0.04), &BOUNDS),
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
            drive(0.13, 0.5, &falling, &BOUNDS),
            (0.0, Verdict::Refused(Edge::Back))
        );
    }

    /// The decay that the passed share leads to, by the same attribution, against the bound; and no larger share keeps it.
    #[test]
    fn what_passes_is_the_most_that_keeps_the_decay_within_bounds() {
        let asked = 0.2_f64;
        for (back, rate) in [(0.12, -0.2), (0.10, -0.1), (0.08, -0.3)] {
            let moving = Margins {
                rate: [rate, 0.0, 0.0, 0.0],
                speed: 0.2,
                ..standing(back)
            };
            let (share, _) = drive(asked as f32, 0.5, &moving, &BOUNDS);
            let k = f64::from(rate) * 0.2 / (0.2 * 0.2 + 0.02 * 0.02);
            let rest = f64::from(rate) - k * 0.2;
            let excess = |share: f64| {
                let decay = rest + k * share * asked;
                decay + (f64::from(back) - 0.05 - share * 0.04) / 0.25
            };
            assert!(share < 1.0 && excess(f64::from(share)) > -1e-5, "{share}");
            assert!(excess(f64::from(share) + 0.01) < 0.0, "{share}");
        }
    }

    #[test]
    fn a_posture_motion_slows_down_before_it_is_refused() {
        let ahead = |back| [back, 0.3, 0.15, 0.15];
        let now = standing(0.08);
        let posture = |now: &Margins, back| posture(now, ahead(back), &BOUNDS);
        assert_eq!(posture(&now, 0.061), (1.0, Verdict::Passed));
        let (share, verdict) = posture(&now, 0.056);
        assert!((share - 0.6).abs() < 1e-4, "{share}");
        assert_eq!(verdict, Verdict::PostureScaled(Edge::Back));
        let refused = (0.0, Verdict::PostureRefused(Edge::Back));
        assert_eq!(posture(&now, 0.049), refused);
        let below = standing(0.03);
        assert_eq!(posture(&below, 0.029), refused);
        assert_eq!(posture(&below, 0.031).0, 1.0);
        assert_eq!(posture(&now, f32::NAN), refused);
    }

    #[test]
    fn backing_down_is_not_refused_for_the_edge_it_leaves() {
        assert_eq!(
            drive(-0.1, 0.9, &standing(0.01), &BOUNDS),
            (1.0, Verdict::Passed)
        );
    }

    #[test]
    fn margins_that_are_no_numbers_refuse() {
        for edge in 0..4 {
            let mut margins = standing(0.3);
            margins.now[edge] = f32::NAN;
            let expected = if edge == 1 { 1.0 } else { 0.0 };
            assert_eq!(
                drive(0.13, 0.5, &margins, &BOUNDS).0,
                expected,
                "edge {edge}"
            );
        }
    }

    #[test]
    fn verdicts_survive_their_codes() {
        for verdict in [
            Verdict::Passed,
            Verdict::Blind(Reason::Silent),
            Verdict::Unattended,
            Verdict::EmergencyStopped,
            Verdict::Doubted(Reason::Disagreement),
        ] {
            assert_eq!(Verdict::from_code(verdict.code()), Some(verdict));
        }
        for edge in EDGES {
            for verdict in [
                Verdict::Scaled(edge),
                Verdict::Refused(edge),
                Verdict::PostureRefused(edge),
                Verdict::PostureScaled(edge),
                Verdict::Tripped(edge),
                Verdict::Overridden(edge),
                Verdict::BackingOff(edge),
            ] {
                assert_eq!(Verdict::from_code(verdict.code()), Some(verdict));
            }
        }
    }

    fn found(gravity: [f32; 4]) -> Evaluation {
        Evaluation {
            margins: gravity,
            gravity,
            ..Evaluation::default()
        }
    }

    #[test]
    fn a_rate_follows_a_slope_but_not_one_sample() {
        let stance = Stance::default();
        let mut tracker = Tracker::default();
        for step in 0..500 {
            let sinking = found([0.3 - 0.001 * step as f32, 0.3, 0.15, 0.15]);
            tracker.update(&stance, &sinking, 0.1, 4e-3);
        }
        let last = [0.3 - 0.001 * 500.0, 0.3, 0.15, 0.15];
        let after = tracker.update(&stance, &found(last), 0.1, 4e-3);
        assert!((after.rate[0] + 0.25).abs() < 1e-3, "{after:?}");
        let jump = tracker.update(&stance, &found([last[0], 0.3, 0.10, 0.15]), 0.1, 4e-3);
        assert!(jump.rate[2] > -0.6, "{jump:?}");
    }

    #[test]
    fn a_bump_narrows_a_margin_but_is_no_decay() {
        let mut tracker = Tracker::default();
        let still = found([0.3; 4]);
        tracker.update(&Stance::default(), &still, 0.1, 4e-3);
        let bump = Evaluation {
            margins: [0.2; 4],
            ..still
        };
        let after = tracker.update(&Stance::default(), &bump, 0.1, 4e-3);
        assert_eq!((after.now, after.rate), ([0.2; 4], [0.0; 4]));
    }

    #[test]
    fn a_margin_that_is_no_number_does_not_outlive_itself() {
        let mut tracker = Tracker::default();
        tracker.update(&Stance::default(), &found([f32::NAN; 4]), 0.0, 4e-3);
        for _ in 0..2 {
            let after = tracker.update(&Stance::default(), &found([0.3; 4]), 0.0, 4e-3);
            assert_eq!(after.rate, [0.0; 4]);
        }
    }
}
