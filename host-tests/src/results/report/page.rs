//! Collects from the samples of a run what its page shows, in bounded memory.

use super::columns::{BALANCE_CURVES, CURVES, Source, steps};
use super::decimation::{Decimated, Merge, Span};
use super::marks::Marks;
use super::path::{Bounds, Path, Pose};
use super::pictures::Pictures;
use crate::results::robot;
use crate::results::summary::intervenes;
use crate::results::zmp::{Balance, Moment};
use crate::scenario::Scenario;
use crate::simulator::record::Sample;
use crate::world::truth::{Sketch, Truth};
use serde_json::Value;

/// The page of a run that goes on.
///
/// Memory: that of 6 000 samples at most, whatever the length of the run.
pub struct Page {
    pub(super) drawing: Drawing,
    /// Step of the contacts' coordinates in the page, m.
    pub(super) contact_one: f64,
    /// Number of drives whose currents are curves of their own.
    pub(super) drives: usize,
    /// The robot-specific channels, in the order of their first occurrence.
    pub(super) channels: Vec<&'static str>,
    /// Distance to the left (positive) and to the right (negative) of the centre of gravity at
    /// which the robot stands, m.
    pub(super) sides: [f64; 2],
    path: Path,
    pub(super) shown: Decimated<Shown>,
    pub(super) balance: Option<Balance>,
    /// The curves of [`BALANCE_CURVES`]; the same intervals as `shown`, half a second late.
    pub(super) moments: Decimated<Vec<Span>>,
    pub(super) marks: Marks,
    pub(super) pictures: Pictures,
}

/// How the page draws the robot, and what it shows of it.
pub(super) enum Drawing {
    /// By the robot's own script.
    Own(OwnPage),
    /// From the sketch and the channels of its plant.
    Sketch(Sketch),
}

/// Parts of the page that belong to one robot.
pub struct OwnPage {
    /// Script with the object `robotPage`, as in sketch.js.
    pub script: &'static str,
    /// What the script reads as `run.own`.
    pub data: Value,
    /// Curves beside those of every robot.
    pub curves: &'static [Source<Sample>],
    /// Computes the places of the axles in the plane from that of axle 1, m.
    pub axles: Box<AxlesOf>,
    /// Radius around the axles, m.
    pub radius_m: f64,
    /// Distance from the middle of the robot to the middle of what it stands on, m.
    pub half_width_m: f64,
}

/// Function of [`OwnPage::axles`].
pub type AxlesOf = dyn Fn(&Truth, [f64; 2]) -> Vec<[f64; 2]> + Send;

/// What the page shows of an interval. All but the curves and the verdict is that of its first
/// sample.
pub(super) struct Shown {
    pub time_s: f64,
    pub odometry_m: f64,
    pub pose: Pose,
    /// Axle 1 and centre of gravity in the plane, m.
    pub axle_1: [f64; 2],
    pub cog: [f64; 2],
    pub bounds: Bounds,
    /// Contacts in the plane, in steps.
    pub contacts: Vec<i32>,
    /// Points of the sketch in the plane, in mm.
    pub points: Vec<i32>,
    /// The curves of every robot, then its own ones, or currents and channels.
    pub curves: Vec<Span>,
    pub guard_state: String,
    /// The first verdict that is an intervention, else that of the first sample.
    pub verdict: String,
}

impl Merge for Shown {
    fn merge(&mut self, later: Self) {
        self.curves.merge(later.curves);
        if !intervenes(&self.verdict) && intervenes(&later.verdict) {
            self.verdict = later.verdict;
        }
    }
}

impl Page {
    /// Begins the page of a run of this scenario.
    pub fn new(scenario: &Scenario) -> Self {
        let own = robot::page(&scenario.robot, scenario.friction);
        let drawing = own.map_or_else(|| Drawing::Sketch(scenario.plant().sketch()), Drawing::Own);
        // Finer steps for a sketch: the contacts of a small robot are close to each other.
        let (contact_one, drives) = match drawing {
            Drawing::Own(_) => (1e-2, 0),
            Drawing::Sketch(_) => (1e-3, scenario.nodes().len() - 1),
        };
        Self {
            drawing,
            contact_one,
            drives,
            channels: Vec::new(),
            sides: [0.0; 2],
            path: Path::default(),
            shown: Decimated::default(),
            balance: Balance::new(scenario),
            moments: Decimated::default(),
            marks: Marks::default(),
            pictures: Pictures::default(),
        }
    }

    /// Adds the next sample.
    pub fn add(&mut self, sample: &Sample) {
        let truth = &sample.truth;
        if self.shown.intervals().is_empty() {
            self.sides = self.sides(truth);
        }
        let pose = self.path.add(truth);
        let (bounds, points) = self.drawing(truth, &pose);
        let contacts = truth.contacts.iter().map(|place| pose.project(*place));
        let shown = Shown {
            time_s: sample.time_s,
            odometry_m: sample.received.odometry,
            axle_1: pose.project(truth.axle_1),
            cog: pose.project(truth.cog),
            bounds,
            contacts: contacts_in_steps(contacts, self.contact_one),
            points,
            curves: self.curves(sample),
            guard_state: sample.received.guard_state.clone(),
            verdict: sample.received.verdict.clone(),
            pose,
        };
        self.shown.add(shown);
        if let Some(balance) = &mut self.balance {
            for moment in balance.add(sample) {
                self.moments.add(balance_curves(moment));
            }
        }
        self.marks.add(sample);
        self.pictures.add(sample);
    }

    /// Adds the moments that are left at the end of the run. Returns the times of the first and the
    /// last sample of the areas A1 to A3, s, with their names.
    pub(super) fn finish_balance(&mut self) -> Vec<(&'static str, f64, f64)> {
        let Some(balance) = self.balance.take().map(Balance::finish) else {
            return Vec::new();
        };
        for moment in balance.moments {
            self.moments.add(balance_curves(moment));
        }
        let areas = ["A1", "A2", "A3"].into_iter().zip(balance.areas);
        let areas = areas.filter(|(_, area)| !area.samples.is_empty());
        areas
            .map(|(name, area)| (name, area.times_s[0], area.times_s[1]))
            .collect()
    }

    fn curves(&mut self, sample: &Sample) -> Vec<Span> {
        let span = |(_, _, source): &Source<Sample>| Span::new(source(sample));
        let mut curves: Vec<_> = CURVES.iter().map(span).collect();
        if let Drawing::Own(own) = &self.drawing {
            curves.extend(own.curves.iter().map(span));
            return curves;
        }
        let current = |drive: usize| sample.received.currents.get(drive).copied();
        curves.extend((0..self.drives).map(|drive| Span::new(current(drive))));
        let channels = &sample.truth.channels;
        for name in channels.keys() {
            if !self.channels.contains(name) {
                self.channels.push(name);
            }
        }
        let value = |name: &&'static str| Span::new(channels.get(name).copied());
        curves.extend(self.channels.iter().map(value));
        curves
    }

    /// Bounds of the robot in the plane, and the points through which it is drawn, in mm.
    fn drawing(&self, truth: &Truth, pose: &Pose) -> (Bounds, Vec<i32>) {
        let points = truth.points.iter();
        let projected: Vec<_> = points.map(|place| pose.project(*place)).collect();
        let steps = in_steps(projected.iter().copied(), 1e-3);
        let (mut places, radius) = match &self.drawing {
            Drawing::Own(own) => {
                let axles = (own.axles)(truth, pose.project(truth.axle_1));
                (axles, own.radius_m)
            }
            Drawing::Sketch(sketch) => {
                let radii = sketch.circles.iter().map(|(_, radius)| *radius);
                (projected.clone(), radii.fold(0.0, f64::max))
            }
        };
        places.push(pose.project(truth.cog));
        let bounds = [0, 1].map(|axis: usize| {
            let values = || places.iter().map(|place| place[axis]);
            [
                values().fold(f64::INFINITY, f64::min) - radius,
                values().fold(f64::NEG_INFINITY, f64::max) + radius,
            ]
        });
        (bounds, steps)
    }

    fn sides(&self, truth: &Truth) -> [f64; 2] {
        if let Drawing::Own(own) = &self.drawing {
            return [own.half_width_m, -own.half_width_m];
        }
        let (sine, cosine) = libm::sincos(truth.yaw);
        let to_left = |place: &[f64; 3]| {
            (place[1] - truth.cog[1]) * cosine - (place[0] - truth.cog[0]) * sine
        };
        let offsets = || truth.points.iter().map(to_left);
        [offsets().fold(0.0, f64::max), offsets().fold(0.0, f64::min)]
    }
}

fn balance_curves(moment: Option<Moment>) -> Vec<Span> {
    let span = |(_, _, source): &Source<Moment>| Span::new(moment.as_ref().and_then(source));
    BALANCE_CURVES.iter().map(span).collect()
}

/// Contacts in the side view, in steps of `one` (m). Left and right contacts that coincide there
/// become one.
fn contacts_in_steps(places: impl Iterator<Item = [f64; 2]>, one: f64) -> Vec<i32> {
    let places = in_steps(places, one);
    let mut points: Vec<_> = places.chunks_exact(2).collect();
    points.sort_unstable();
    points.dedup();
    points.concat()
}

/// Coordinates of all places in one list, in steps of `one` (m).
fn in_steps(places: impl Iterator<Item = [f64; 2]>, one: f64) -> Vec<i32> {
    let steps = |metres: f64| steps(metres, one);
    places.flat_map(|place| place.map(steps)).collect()
}
