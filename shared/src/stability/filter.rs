//! What the guard leaves of a command: all of it while the margins are wide, a share of it in the caution band, nothing
//! below. It never adds motion of its own.

use super::support::{EDGES, Edge, Stance};
use crate::math::{clamp, min};

/// Bounds of the filter, m and s.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Below this predicted margin a command is scaled.
    pub caution: f32,
    /// At and below this predicted margin a command is refused; below [`Self::caution`].
    pub stop: f32,
    /// How far ahead margins are extrapolated.
    pub horizon: f32,
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
    Blind,
    /// Nothing passed: no operator was heard in time.
    Unattended,
}

impl Verdict {
    /// Code in object 0x4001:2: kind in the high half, edge in the low half.
    pub fn code(self) -> u8 {
        match self {
            Self::Passed => 0x00,
            Self::Scaled(edge) => 0x10 | edge as u8,
            Self::Refused(edge) => 0x20 | edge as u8,
            Self::PostureRefused(edge) => 0x30 | edge as u8,
            Self::Blind => 0x40,
            Self::Unattended => 0x50,
        }
    }

    /// The verdict with this code.
    pub fn from_code(code: u8) -> Option<Self> {
        let edge = *EDGES.get(usize::from(code & 0x0f))?;
        Some(match code >> 4 {
            0 => Self::Passed,
            1 => Self::Scaled(edge),
            2 => Self::Refused(edge),
            3 => Self::PostureRefused(edge),
            4 => Self::Blind,
            5 => Self::Unattended,
            _ => return None,
        })
    }
}

/// Margins with their rates.
#[derive(Clone, Copy, Debug, Default)]
pub struct Margins {
    /// m, indexed by [`Edge`].
    pub now: [f32; 4],
    /// m/s.
    pub rate: [f32; 4],
}

impl Margins {
    /// The margin `horizon` seconds ahead if it goes on shrinking as it does; growth is not counted on.
    pub fn predicted(&self, edge: Edge, horizon: f32) -> f32 {
        let index = edge as usize;
        self.now[index] + min(self.rate[index], 0.0) * horizon
    }
}

/// Tracks margins and their rates from one evaluation to the next.
#[derive(Clone, Debug, Default)]
pub struct Tracker {
    margins: Option<Margins>,
    contacts: [bool; 4],
}

impl Tracker {
    /// Time in which the rate follows, s: a single sample moves it little.
    const RATE_TIME: f32 = 0.1;

    /// Takes the stance `period` s after the evaluation before. The rates begin anew when other wheels stand than before.
    pub fn update(&mut self, stance: &Stance, period: f32) -> Margins {
        let now = stance.margins();
        let contacts = stance.contacts.map(|contact| contact.is_some());
        let margins = match self.margins {
            Some(before) if contacts == self.contacts => {
                let share = period / (Self::RATE_TIME + period);
                let mut rate = before.rate;
                for index in 0..4 {
                    let slope = (now[index] - before.now[index]) / period;
                    rate[index] += (slope - rate[index]) * share;
                }
                Margins { now, rate }
            }
            _ => Margins {
                now,
                rate: [0.0; 4],
            },
        };
        self.contacts = contacts;
        self.margins = Some(margins);
        margins
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
        let predicted = margins.predicted(edge, bounds.horizon);
        // Margins are tens of millimetres; the bound below keeps the division away from zero.
        let band = if bounds.caution - bounds.stop > 1e-3 {
            bounds.caution - bounds.stop
        } else {
            1e-3
        };
        let left = clamp((predicted - bounds.stop) / band, 0.0, 1.0);
        let left = if left >= 0.0 { left } else { 0.0 };
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

/// Whether the posture may go on: refused when the margins it leads to are below the stop margin and narrower than
/// now. `ahead` are the margins of the shape that the motion leads to.
pub fn posture(margins: &Margins, ahead: [f32; 4], bounds: &Bounds) -> Verdict {
    for edge in [Edge::Back, Edge::Left, Edge::Right] {
        let (now, then) = (margins.now[edge as usize], ahead[edge as usize]);
        let safe = then >= bounds.stop || then >= now;
        if !safe {
            return Verdict::PostureRefused(edge);
        }
    }
    Verdict::Passed
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
    fn a_shrinking_margin_counts_as_what_it_will_be() {
        let falling = Margins {
            rate: [-0.4, 0.0, 0.0, 0.0],
            ..standing(0.14)
        };
        assert_eq!(
            drive(0.13, 0.5, &falling, &BOUNDS),
            (0.0, Verdict::Refused(Edge::Back))
        );
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
        for verdict in [Verdict::Passed, Verdict::Blind, Verdict::Unattended] {
            assert_eq!(Verdict::from_code(verdict.code()), Some(verdict));
        }
        for edge in EDGES {
            for verdict in [
                Verdict::Scaled(edge),
                Verdict::Refused(edge),
                Verdict::PostureRefused(edge),
            ] {
                assert_eq!(Verdict::from_code(verdict.code()), Some(verdict));
            }
        }
    }

    #[test]
    fn a_rate_follows_a_slope_but_not_one_sample() {
        // A square of 0.6 m by 0.3 m around a centre of gravity that is `back` before its rear edge.
        let stance = |back: f32, left: f32| {
            Stance::on(
                [
                    [0.0, -0.15, 0.0],
                    [0.6, -0.15, 0.0],
                    [0.6, 0.15, 0.0],
                    [0.0, 0.15, 0.0],
                ],
                [back, 0.15 - left, 0.2],
            )
        };
        let mut tracker = Tracker::default();
        for step in 0..500 {
            tracker.update(&stance(0.55 - 0.001 * step as f32, 0.15), 4e-3);
        }
        let after = tracker.update(&stance(0.05, 0.15), 4e-3);
        assert!((after.rate[0] + 0.25).abs() < 1e-3, "{after:?}");
        let jump = tracker.update(&stance(0.05, 0.10), 4e-3);
        assert!(jump.rate[2] > -0.6, "{jump:?}");
    }
}
