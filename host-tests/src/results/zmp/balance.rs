//! Follows centre of gravity and zero moment point through a run, sample by sample.

use super::figures::Sums;
use super::smoothing::Smoothing;
use super::{Figures, Moment, OwnBalance};
use crate::results::phases::{Boundary, Phases, Undecided};
use crate::results::robot;
use crate::scenario::Scenario;
use crate::simulator::record::Sample;
use crate::world::ground::Ground;
use crate::world::truth::Truth;
use std::ops::Range;

/// Centre of gravity and zero moment point of a run that goes on.
pub struct Balance {
    own: OwnBalance,
    /// The first nose and the last but one, m; `None` on ground without a nose.
    noses_m: Option<[f64; 2]>,
    /// The last sample but one.
    before: Option<Truth>,
    last: Option<(f64, Truth)>,
    smoothing: Smoothing,
    phases: Phases,
    toppled: Option<Boundary>,
    /// Where the centre of gravity passed the noses during the climb.
    past: [Option<Boundary>; 2],
    /// Number of smoothed moments.
    smoothed: usize,
    undecided: Undecided<Moment>,
    sums: Sums,
}

/// Centre of gravity and zero moment point over a whole run.
#[derive(Clone, Debug, Default)]
pub struct BalanceOfRun {
    /// The moments that [`Balance::add`] has not returned.
    pub moments: Vec<Option<Moment>>,
    /// The areas of the figure. A1 lasts from the start of the climb until the centre of gravity is
    /// past the first nose. A2 lasts until it is past the last nose but one. A3 lasts until the
    /// landing. An area that the run never reached is empty.
    pub areas: [Area; 3],
    /// Figures over the three areas; `None` if the robot never climbed.
    pub figures: Option<Figures>,
}

/// An area of the paper's figure.
#[derive(Clone, Debug, Default)]
pub struct Area {
    /// Indices of its samples.
    pub samples: Range<usize>,
    /// Times of its first and its last sample, s; without meaning if it is empty.
    pub times_s: [f64; 2],
}

impl Balance {
    /// Begins a run of this scenario; `None` for a robot without a balance of its own.
    pub fn new(scenario: &Scenario) -> Option<Self> {
        let own = robot::balance(&scenario.robot, scenario.friction)?;
        let noses_m = match scenario.terrain.ground() {
            Ground::Stairs(stairs) => {
                let first = stairs.first_nose_x;
                Some([first, f64::max(first, stairs.last_nose_x() - stairs.run)])
            }
            Ground::Curb { front_x, .. } => Some([front_x, front_x]),
            Ground::Flat | Ground::Ramp { .. } | Ground::Incline { .. } => None,
        };
        Some(Self {
            own,
            noses_m,
            before: None,
            last: None,
            smoothing: Smoothing::default(),
            phases: Phases::new(scenario),
            toppled: None,
            past: [None; 2],
            smoothed: 0,
            undecided: Undecided::default(),
            sums: Sums::default(),
        })
    }

    /// Computes the balance over the samples of a run; empty for a robot without a balance of its
    /// own.
    pub fn over(scenario: &Scenario, samples: &[Sample]) -> BalanceOfRun {
        let Some(mut balance) = Self::new(scenario) else {
            return BalanceOfRun::default();
        };
        let mut moments: Vec<_> = samples.iter().flat_map(|it| balance.add(it)).collect();
        let mut run = balance.finish();
        moments.append(&mut run.moments);
        BalanceOfRun { moments, ..run }
    }

    /// Adds the next sample. Returns the moments that are due, at most one: those of all samples
    /// follow each other, about half a second late. The first and the last sample have none.
    pub fn add(&mut self, sample: &Sample) -> Vec<Option<Moment>> {
        self.follow(sample);
        let here = (sample.time_s, sample.truth.clone());
        let Some((time_s, last)) = self.last.replace(here) else {
            return Vec::new();
        };
        let before = self.before.replace(last.clone());
        let found =
            before.and_then(|before| (self.own.moment)(time_s, [&before, &last, &sample.truth]));
        let smoothed = self.smoothing.add(time_s, found);
        self.count(&smoothed);
        smoothed
    }

    /// Length of the straight robot, m.
    pub fn length_m(&self) -> f64 {
        self.own.length_m
    }

    /// Ends the run.
    pub fn finish(mut self) -> BalanceOfRun {
        let mut smoothing = std::mem::take(&mut self.smoothing);
        let last = self.last.take();
        let mut moments = last.map_or_else(Vec::new, |(time_s, _)| smoothing.add(time_s, None));
        moments.extend(smoothing.finish());
        self.count(&moments);
        self.add_decided(usize::MAX);
        let areas = self.areas();
        BalanceOfRun {
            moments,
            figures: areas
                .as_ref()
                .and_then(|_| self.sums.figures(100.0 / self.own.length_m)),
            areas: areas.unwrap_or_default(),
        }
    }

    /// Follows the phases of the run.
    fn follow(&mut self, sample: &Sample) {
        let here = Boundary {
            time_s: sample.time_s,
            ..self.phases.end()
        };
        self.phases.add(sample);
        if sample.truth.toppled {
            self.toppled = self.toppled.or(Some(here));
        }
        if self.phases.climb().is_some() {
            for (past, nose) in self.past.iter_mut().zip(self.noses_m.iter().flatten()) {
                if sample.truth.cog[0] > *nose {
                    *past = past.or(Some(here));
                }
            }
        }
    }

    fn count(&mut self, smoothed: &[Option<Moment>]) {
        for moment in smoothed {
            if let Some(moment) = moment {
                self.undecided.add(self.smoothed, *moment);
            }
            self.smoothed += 1;
        }
        self.add_decided(self.phases.decided());
    }

    /// Adds up the moments of the climb before `until`. The climb ends early if the robot topples.
    fn add_decided(&mut self, until: usize) {
        let until_toppled = self.toppled.map_or(usize::MAX, |toppled| toppled.index);
        for moment in self.undecided.take(&self.phases, until.min(until_toppled)) {
            self.sums.add(&moment);
        }
    }

    /// Splits the climb into the three areas; `None` on ground without a nose.
    fn areas(&self) -> Option<[Area; 3]> {
        self.noses_m?;
        let earlier = |a: Boundary, b: Boundary| if b.index < a.index { b } else { a };
        let end = self.phases.landing().unwrap_or(self.phases.end());
        let end = self.toppled.map_or(end, |toppled| earlier(end, toppled));
        let until_end = |at: Option<Boundary>| at.map_or(end, |at| earlier(end, at));
        let [first, last] = self.past.map(until_end);
        let start = until_end(self.phases.climb());
        let area = |[from, to]: [Boundary; 2]| Area {
            samples: from.index..to.index,
            times_s: [from.time_s, to.before_s],
        };
        Some([[start, first], [first, last], [last, end]].map(area))
    }
}
