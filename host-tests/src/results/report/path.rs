//! Computes the side view: the robot's path unrolled into a plane, the ground along it, and a
//! camera that follows the robot.
//!
//! The plane is vertical and contains the robot's heading. Its horizontal axis is the distance that
//! the centre of gravity moved along the heading; its vertical axis is the world's z. So a robot
//! that drives a loop stays in the picture, above the ground on which it stands.

use super::columns::steps;
use crate::world::Plant;
use crate::world::truth::Truth;
use serde::Serialize;

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

/// A rectangle in the plane: minimum and maximum along both axes, m.
pub(super) type Bounds = [[f64; 2]; 2];

/// The unrolled path of a run that goes on.
#[derive(Default)]
pub(super) struct Path {
    last: Option<Pose>,
}

/// Place of the plane at one sample.
#[derive(Clone, Copy)]
pub(super) struct Pose {
    cog: [f64; 3],
    heading: [f64; 2],
    /// Distance along the path of the centre of gravity, m.
    along: f64,
}

impl Path {
    /// Adds the next sample. The path begins at the x that the first sample has if its heading is
    /// along x.
    pub fn add(&mut self, truth: &Truth) -> Pose {
        // A robot that lies on its side or on its back has no heading, so the last one is kept.
        let heading = match self.last {
            Some(last) if truth.toppled => last.heading,
            _ => [libm::cos(truth.yaw), libm::sin(truth.yaw)],
        };
        let [x, y, _] = truth.cog;
        let (from, begin) = self.last.map_or(([0.0; 2], 0.0), |last| {
            let [x, y, _] = last.cog;
            ([x, y], last.along)
        });
        let pose = Pose {
            cog: truth.cog,
            heading,
            along: begin + dot([x - from[0], y - from[1]], heading),
        };
        self.last = Some(pose);
        pose
    }
}

impl Pose {
    /// Projects a point of the world into the plane.
    pub fn project(&self, [x, y, z]: [f64; 3]) -> [f64; 2] {
        let [cog_x, cog_y, _] = self.cog;
        let offset = [x - cog_x, y - cog_y];
        [self.along + dot(offset, self.heading), z]
    }

    /// Whether the section of ground along this heading can also be shown at `other`.
    fn serves(&self, other: &Self) -> bool {
        let (from, to) = (self.heading, other.heading);
        let went = other.along - self.along;
        let beside = [0, 1].map(|axis| other.cog[axis] - self.cog[axis] - went * from[axis]);
        dot(beside, beside).sqrt() < BESIDE && (from[0] * to[1] - from[1] * to[0]).abs() < TURNED
    }

    /// The ground along this heading, `side` m to its left, between two distances.
    fn section(&self, plant: &dyn Plant, side: f64, [least, most]: [f64; 2]) -> Vec<[f64; 2]> {
        let heading = self.heading;
        let [x, y, _] = self.cog;
        let from = [x - side * heading[1], y + side * heading[0]];
        let zero = self.along;
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

/// The ground in the plane, as long as the robot is at one of the poses.
#[derive(Serialize)]
pub(super) struct Section {
    /// Index of the first of these poses.
    from: usize,
    /// The ground under the middle of the robot: distance and height of all points in one list, in
    /// steps of [`GROUND_ONE`].
    middle: Vec<i32>,
    /// The ground under the left and the right side, if it differs there.
    #[serde(skip_serializing_if = "Option::is_none")]
    left: Option<Vec<i32>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    right: Option<Vec<i32>>,
}

/// The ground in the plane, for a picture that is `width` m wide. The offsets `sides` are those of
/// the robot's left and right side.
pub(super) fn ground(
    poses: &[Pose],
    plant: &dyn Plant,
    width: f64,
    sides: [f64; 2],
) -> Vec<Section> {
    let mut sections = Vec::new();
    let mut begin = 0;
    while let Some(first) = poses.get(begin) {
        let served = poses[begin + 1..]
            .iter()
            .take_while(|pose| first.serves(pose));
        let end = begin + 1 + served.count();
        let places = || poses[begin..end].iter().map(|pose| pose.along);
        let least = places().fold(f64::INFINITY, f64::min);
        let most = places().fold(f64::NEG_INFINITY, f64::max);
        let range = [least - 0.6 * width, most + 0.6 * width];
        let [middle, left, right] =
            [0.0, sides[0], sides[1]].map(|side| first.section(plant, side, range));
        let differs = differ(&middle, &left) || differ(&middle, &right);
        sections.push(Section {
            from: begin,
            middle: packed(&middle),
            left: differs.then(|| packed(&left)),
            right: differs.then(|| packed(&right)),
        });
        begin = end;
    }
    sections
}

/// Computes the camera for a robot with these bounds, `period_s` apart.
pub(super) fn camera(bounds: &[Bounds], period_s: f64) -> Camera {
    let sizes = bounds.iter().flatten().map(|[from, to]| to - from);
    let scale = sizes.fold(0.1, f64::max);
    let calm = (CALM_S / period_s.max(1e-3)) as usize;
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

/// Size and positions of the picture, sample by sample.
pub(super) struct Camera {
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

fn packed(points: &[[f64; 2]]) -> Vec<i32> {
    let values = points.as_flattened().iter();
    values.map(|value| steps(*value, GROUND_ONE)).collect()
}
