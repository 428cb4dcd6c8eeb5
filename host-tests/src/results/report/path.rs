//! Computes the side view: the robot's path unrolled into a plane, the ground along it, and a
//! camera that follows the robot.
//!
//! The plane is vertical and contains the robot's heading. Its horizontal axis is the distance that
//! the centre of gravity moved along the heading; its vertical axis is the world's z. So a robot
//! that drives a loop stays in the picture, above the ground on which it stands.

use crate::simulator::record::Sample;
use crate::world::Plant;
use serde_json::{Value, json};

/// Distance between the points at which the ground's height is sampled, m.
const GROUND_STEP: f64 = 0.04;
/// Half the distance between the two points at a step's vertical face, m.
const FACE: f64 = 1e-6;
/// A point of the ground that is at most this far from the line between its neighbours is left out,
/// m.
const STRAIGHT: f64 = 0.5e-3;
/// A section of the ground is used until the robot is this far beside its line, m, or has turned
/// this far away from it (sine of the angle).
const BESIDE: f64 = 8e-3;
const TURNED: f64 = 0.02;
/// Width and height of the picture on a wide and on a narrow screen, as multiples of the robot's
/// largest dimension.
const WIDE: [f64; 2] = [3.8, 1.4];
const NARROW: [f64; 2] = [2.0, 1.4];
/// Minimum empty space around the robot in the picture, as a multiple of the robot's largest
/// dimension.
const AIR: f64 = 0.1;
/// Half the time over which the camera's position is averaged, s.
const CALM_S: f64 = 0.5;
/// Step of the ground's coordinates in the page, m.
pub const GROUND_ONE: f64 = 1e-3;

/// The unrolled path of a series of samples.
pub struct Path<'a> {
    samples: Vec<&'a Sample>,
    /// Distance along the path of each sample's centre of gravity, m.
    along: Vec<f64>,
    headings: Vec<[f64; 2]>,
}

/// A rectangle in the plane: minimum and maximum along both axes, m.
pub type Bounds = [[f64; 2]; 2];

impl<'a> Path<'a> {
    /// Unrolls the path of `samples`, which are in order of time. The path begins at the x that the
    /// first sample has if its heading is along x.
    pub fn new(samples: Vec<&'a Sample>) -> Self {
        let mut along: Vec<f64> = Vec::with_capacity(samples.len());
        let mut headings: Vec<[f64; 2]> = Vec::with_capacity(samples.len());
        for (index, sample) in samples.iter().enumerate() {
            let before = index.checked_sub(1);
            // A robot that lies on its side or on its back has no heading, so the last one is kept.
            let heading = match before {
                Some(before) if sample.truth.toppled => headings[before],
                _ => [libm::cos(sample.truth.yaw), libm::sin(sample.truth.yaw)],
            };
            let [x, y, _] = sample.truth.cog;
            let (from, begin) = before.map_or(([0.0; 2], 0.0), |before| {
                let [x, y, _] = samples[before].truth.cog;
                ([x, y], along[before])
            });
            along.push(begin + dot([x - from[0], y - from[1]], heading));
            headings.push(heading);
        }
        Self {
            samples,
            along,
            headings,
        }
    }

    /// Projects a point of the world into the plane of sample `index`.
    pub fn project(&self, index: usize, [x, y, z]: [f64; 3]) -> [f64; 2] {
        let [cog_x, cog_y, _] = self.samples[index].truth.cog;
        let offset = [x - cog_x, y - cog_y];
        [self.along[index] + dot(offset, self.headings[index]), z]
    }

    /// Computes the camera for a robot with these bounds at each sample.
    pub fn camera(&self, bounds: &[Bounds]) -> Camera {
        let sizes = bounds.iter().flatten().map(|[from, to]| to - from);
        let scale = sizes.fold(0.1, f64::max);
        let pairs = self.samples.windows(2);
        let period = pairs.map(|pair| pair[1].time_s - pair[0].time_s).next();
        let calm = (CALM_S / period.unwrap_or(CALM_S).max(1e-3)) as usize;
        let centres = [0, 1].map(|axis| {
            let middle = |bounds: &Bounds| 0.5 * (bounds[axis][0] + bounds[axis][1]);
            // Cumulative sums: the difference of two is the sum over a window.
            let mut sums = vec![0.0];
            for bounds in bounds {
                sums.push(sums[sums.len() - 1] + middle(bounds));
            }
            let room = (0.5 * NARROW[axis] - AIR) * scale;
            let centre = |(index, bounds): (usize, &Bounds)| {
                let from = index.saturating_sub(calm);
                let to = (index + calm + 1).min(sums.len() - 1);
                let mean = (sums[to] - sums[from]) / (to - from) as f64;
                let [least, greatest] = bounds[axis];
                mean.max(greatest - room).min(least + room)
            };
            bounds.iter().enumerate().map(centre).collect()
        });
        Camera { scale, centres }
    }

    /// The ground in the plane, for a picture that is `width` m wide: a list of sections, each with
    /// the sample from which it is used. A section has the ground under the middle of the robot,
    /// and also at the offsets `sides` to its left and right if the ground differs there.
    pub fn ground(&self, plant: &dyn Plant, width: f64, sides: [f64; 2]) -> Vec<Value> {
        let mut sections = Vec::new();
        let mut begin = 0;
        while begin < self.samples.len() {
            let end = (begin + 1..self.samples.len())
                .find(|index| !self.serves(begin, *index))
                .unwrap_or(self.samples.len());
            let places = &self.along[begin..end];
            let least = places.iter().copied().fold(f64::INFINITY, f64::min);
            let most = places.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let range = [least - 0.6 * width, most + 0.6 * width];
            let [middle, left, right] =
                [0.0, sides[0], sides[1]].map(|side| self.section(plant, begin, side, range));
            let mut section = json!({ "from": begin, "middle": packed(&middle) });
            if differ(&middle, &left) || differ(&middle, &right) {
                section["left"] = packed(&left);
                section["right"] = packed(&right);
            }
            sections.push(section);
            begin = end;
        }
        sections
    }

    /// Whether the section of ground along the heading of sample `first` can also be shown at
    /// sample `index`.
    fn serves(&self, first: usize, index: usize) -> bool {
        let (from, to) = (self.headings[first], self.headings[index]);
        let went = self.along[index] - self.along[first];
        let [a, b] = [first, index].map(|index| self.samples[index].truth.cog);
        let beside = [0, 1].map(|axis| b[axis] - a[axis] - went * from[axis]);
        dot(beside, beside).sqrt() < BESIDE && (from[0] * to[1] - from[1] * to[0]).abs() < TURNED
    }

    /// The ground along the heading of sample `index`, `side` m to its left, between two distances.
    fn section(
        &self,
        plant: &dyn Plant,
        index: usize,
        side: f64,
        [least, most]: [f64; 2],
    ) -> Vec<[f64; 2]> {
        let heading = self.headings[index];
        let [x, y, _] = self.samples[index].truth.cog;
        let from = [x - side * heading[1], y + side * heading[0]];
        let zero = self.along[index];
        let steps = ((most - least) / GROUND_STEP).ceil() as u32;
        let mut places: Vec<f64> = (0..=steps)
            .map(|step| least + (most - least) * f64::from(step) / f64::from(steps))
            .collect();
        let edges = plant.ground_edges(from, heading).into_iter();
        let edges = edges.map(|edge| edge + zero);
        let inside = edges.filter(|edge| (least..most).contains(edge));
        places.extend(inside.flat_map(|edge| [edge - FACE, edge + FACE]));
        places.sort_by(f64::total_cmp);
        let height = |place: f64| {
            let [x, y] = [0, 1].map(|axis| from[axis] + (place - zero) * heading[axis]);
            [place, plant.ground_height([x, y])]
        };
        let points: Vec<_> = places.into_iter().map(height).collect();
        let mut kept = vec![points[0]];
        simplify(&points, &mut kept);
        kept
    }
}

/// Size and positions of the picture, sample by sample.
pub struct Camera {
    /// The robot's largest dimension, m.
    pub scale: f64,
    /// Centre of the picture at each sample, along both axes, m.
    pub centres: [Vec<f64>; 2],
}

impl Camera {
    /// Width and height of the picture on a wide screen, m.
    pub fn wide(&self) -> [f64; 2] {
        WIDE.map(|size| size * self.scale)
    }

    /// Width and height of the picture on a narrow screen, m.
    pub fn narrow(&self) -> [f64; 2] {
        NARROW.map(|size| size * self.scale)
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Simplifies a line of points (Douglas and Peucker): adds to `kept` the points after the first
/// that a line within [`STRAIGHT`] of all points needs.
fn simplify(points: &[[f64; 2]], kept: &mut Vec<[f64; 2]>) {
    let (Some([x0, z0]), Some([x1, z1])) = (points.first(), points.last()) else {
        return;
    };
    let off = |[x, z]: [f64; 2]| (z - z0 - (z1 - z0) * (x - x0) / (x1 - x0)).abs();
    let inner = 1..points.len().saturating_sub(1);
    let farthest = inner.max_by(|a, b| off(points[*a]).total_cmp(&off(points[*b])));
    match farthest {
        Some(index) if off(points[index]) > STRAIGHT => {
            simplify(&points[..=index], kept);
            simplify(&points[index..], kept);
        }
        _ if points.len() > 1 => kept.push([*x1, *z1]),
        _ => {}
    }
}

/// Whether two lines of ground differ visibly in a picture.
fn differ(a: &[[f64; 2]], b: &[[f64; 2]]) -> bool {
    let apart = |(a, b): (&[f64; 2], &[f64; 2])| {
        (a[0] - b[0]).abs() > 2.0 * GROUND_ONE || (a[1] - b[1]).abs() > 2.0 * GROUND_ONE
    };
    a.len() != b.len() || a.iter().zip(b).any(apart)
}

/// Distance and height of all points in one list, in steps of [`GROUND_ONE`].
fn packed(points: &[[f64; 2]]) -> Value {
    let steps = points.as_flattened().iter();
    steps
        .map(|value| (value / GROUND_ONE).round() as i64)
        .collect()
}
