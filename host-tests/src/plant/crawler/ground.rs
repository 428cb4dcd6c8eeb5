//! The ground's shape: a plane, and from some line on another one. World axes: x forward, y left, z up.

use crate::plant::world::turn;
use rapier3d_f64::math::{Rotation, Vector};

/// What the crawler drives on: ground that may rise to the left everywhere, and forward from some place on.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Profile {
    /// Rise to the left, rad.
    pub cross: f64,
    /// Rise forward, rad; negative is downhill.
    pub slope: f64,
    /// Distance ahead of the origin at which it begins to rise forward, m; `None`: it does everywhere.
    pub from_x: Option<f64>,
}

/// A plane, the ground below it.
#[derive(Clone, Copy, Debug)]
struct Plane {
    normal: Vector,
    /// Distance from the origin along the normal, m.
    offset: f64,
}

/// One or two planes.
#[derive(Clone, Copy, Debug)]
pub struct Ground {
    planes: [Plane; 2],
    /// They meet in a valley, not on a ridge.
    valley: bool,
    start: Rotation,
}

impl Ground {
    /// The ground of a profile.
    pub fn new(profile: &Profile) -> Self {
        let across = turn(Vector::X, profile.cross);
        let rising = across * turn(Vector::NEG_Y, profile.slope);
        let second = rising * Vector::Z;
        let (first, fold) = match profile.from_x {
            Some(x) => (across * Vector::Z, across * Vector::new(x, 0.0, 0.0)),
            None => (second, Vector::ZERO),
        };
        Self {
            planes: [
                Plane {
                    normal: first,
                    offset: 0.0,
                },
                Plane {
                    normal: second,
                    offset: second.dot(fold),
                },
            ],
            valley: profile.slope >= 0.0,
            start: if profile.from_x.is_some() {
                across
            } else {
                rising
            },
        }
    }

    /// Attitude of a robot that stands on the origin and heads along x.
    pub fn start(&self) -> Rotation {
        self.start
    }

    /// Height of a point above the ground, m, and the ground's normal there.
    pub fn height(&self, point: Vector) -> (f64, Vector) {
        let [first, second] = self
            .planes
            .map(|plane| (plane.normal.dot(point) - plane.offset, plane.normal));
        if (first.0 <= second.0) == self.valley {
            first
        } else {
            second
        }
    }
}
