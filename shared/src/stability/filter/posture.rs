//! Computes the scale of a posture's speed.

use super::bounds::{Bounds, sway};
use super::{Margins, Verdict};
use crate::math::{max, min};
use crate::stability::support::EDGES;

/// Scale of a posture's speed below which the motion counts as refused.
pub(in crate::stability) const SMALLEST_SHARE: f32 = 0.05;

/// Decay below which a rate is noise, m/s.
const STEADY: f32 = 0.01;

/// Minimum scale of a posture motion at an edge whose margin does not shrink by the change of shape
/// alone. It holds even at the narrowest margin, because the motion may lead out of danger.
const RESCUE: f32 = 0.1;

/// Scale of a posture's speed, 0 to 1, and the verdict. `ahead` are the margins, m, of the shape
/// that the motion reaches after [`Bounds::foresight`].
///
/// The shape does not determine the pitch alone: a front that meets the ground lifts the body. So
/// the prediction for each edge is the margin in `ahead`, less what the measured decay takes away
/// within [`Bounds::foresight`]. If the prediction is narrower than the present margin, the motion
/// slows down through the caution band and ends at the stop margin, both in terms of the energy
/// that is left ([`Tipping::margin`]). A steep robot on the nose of a step also sways when its
/// centre of gravity moves. To allow for that, the caution band moves up with the pitch ([`sway`]).
/// If the prediction is not narrower than the present margin, the motion slows down only below the
/// stop margin. If the shape alone, without the decay, does not narrow the margin, the scale never
/// falls below [`RESCUE`]. NaN refuses.
///
/// [`Tipping::margin`]: crate::stability::energy::Tipping::margin
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
            bounds.away.scale(now)
        } else {
            let reserve = sway(edge, pitch) * bounds.towards.width();
            let left = bounds.tipping[index].margin(then + decay, 0.0);
            // `min` is here only for NaN: if `now` is NaN, the result is NaN, which refuses.
            bounds.towards.scale(min(left - reserve, now))
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
    use super::super::examples::{BOUNDS, standing};
    use super::*;
    use crate::stability::support::Edge;

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

    /// Margins with `back` m at the rear edge.
    fn ahead(back: f32) -> [f32; 4] {
        [back, 0.3, 0.15, 0.15]
    }

    #[test]
    fn a_posture_motion_that_narrows_a_margin_slows_down_before_it_is_refused() {
        let now = standing(0.14);
        let posture = |back| posture(0.0, &now, ahead(back), &BOUNDS);
        assert_eq!(posture(0.091), (1.0, Verdict::Passed));
        let (scale, verdict) = posture(0.06);
        assert!((scale - 0.25).abs() < 1e-4, "{scale}");
        assert_eq!(verdict, Verdict::PostureScaled(Edge::Back));
        let refused = (0.0, Verdict::PostureRefused(Edge::Back));
        assert_eq!(posture(0.049), refused);
        assert_eq!(posture(f32::NAN), refused);
    }

    /// At 0.5 rad of pitch the motion ends at the caution margin; at 0.25 rad, in the middle of the
    /// caution band.
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
            let scale =
                |pitch: f32, margin| posture(pitch, &now, narrowing(edge, margin), &BOUNDS).0;
            for (pitch, end) in [
                (-pitch, 0.05),
                (0.0, 0.05),
                (0.5 * pitch, 0.07),
                (pitch, 0.09),
                (2.0 * pitch, 0.09),
            ] {
                assert_eq!(scale(pitch, end - 1e-3), 0.0, "{edge:?} {pitch}");
                let half = scale(pitch, end + 0.02);
                assert!((half - 0.5).abs() < 1e-4, "{edge:?} {pitch}: {half}");
                assert_eq!(scale(pitch, end + 0.041), 1.0, "{edge:?} {pitch}");
            }
        }
        for edge in [Edge::Left, Edge::Right] {
            for pitch in [-1.0, 1.0] {
                let (scale, _) = posture(pitch, &now, narrowing(edge, 0.07), &BOUNDS);
                assert!((scale - 0.5).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn a_posture_motion_that_widens_a_narrow_margin_is_slow_but_goes_on() {
        let scale = |now: f32| posture(1.0, &standing(now), ahead(now + 0.01), &BOUNDS).0;
        assert_eq!(scale(0.051), 1.0);
        assert!((scale(0.03) - 0.5).abs() < 1e-4);
        assert!((scale(0.012) - RESCUE).abs() < 1e-6);
        assert!((scale(-0.01) - RESCUE).abs() < 1e-6);
    }

    /// The margin falls by 0.2 m/s: 30 mm within the horizon, in addition to the change that the
    /// shape predicts.
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
                let left = |scale: f32| 0.05 + 0.04 * scale + 0.03 - change;
                assert_eq!(posture(left(1.01), change), (1.0, Verdict::Passed));
                assert!((posture(left(0.5), change).0 - 0.5).abs() < 1e-4);
            }
            assert_eq!(posture(0.09, -0.02), (0.0, Verdict::PostureRefused(edge)));
            let (rescued, verdict) = posture(0.05, 0.02);
            assert!((rescued - RESCUE).abs() < 1e-6);
            assert_eq!(verdict, Verdict::PostureScaled(edge));
        }
    }

    /// In the caution band a decay would end the motion, except for the rescue.
    #[test]
    fn a_rate_within_the_noise_is_no_decay() {
        for edge in EDGES {
            let scale = |rate: f32| {
                let mut margins = standing(0.3);
                margins.now = [0.3; 4];
                margins.now[edge as usize] = 0.055;
                margins.rate[edge as usize] = rate;
                posture(0.0, &margins, margins.now, &BOUNDS).0
            };
            for rate in [0.9 * STEADY, 0.0, -0.9 * STEADY, -STEADY] {
                assert_eq!(scale(rate), 1.0, "{edge:?} {rate}");
            }
            assert!(scale(-1.1 * STEADY) < 0.2, "{edge:?}");
        }
    }
}
