//! Shape of the crawler's ground: a plane that may turn into another plane along a line. World
//! axes: x forward, y left, z up.

use crate::world::physics::turn;
use rapier3d_f64::math::{Rotation, Vector};

/// Profile of the ground: it may rise to the left everywhere, and forward from some place on.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Profile {
    /// Rise to the left, rad.
    pub cross: f64,
    /// Rise forward, rad; negative is downhill.
    pub slope: f64,
    /// Distance ahead of the origin from which the ground rises forward, m; `None` if it rises
    /// everywhere.
    pub from_x: Option<f64>,
    /// Height above the origin at which the rise ends in a level plateau, m.
    pub plateau: Option<f64>,
}

/// Plane, with the ground below it.
#[derive(Clone, Copy, Debug)]
struct Plane {
    normal: Vector,
    /// Distance from the origin along the normal, m.
    offset: f64,
}

/// Ground of one or two planes, and a plateau.
#[derive(Clone, Copy, Debug)]
pub struct Ground {
    planes: [Plane; 2],
    /// Whether the two planes meet in a valley, not on a ridge.
    valley: bool,
    plateau: Option<Plane>,
    start: Rotation,
}

impl Ground {
    /// Creates the ground of a profile.
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
            plateau: profile.plateau.map(|offset| Plane {
                normal: Vector::Z,
                offset,
            }),
            start: if profile.from_x.is_some() {
                across
            } else {
                rising
            },
        }
    }

    /// Attitude of a robot that stands at the origin and faces along x.
    pub fn start(&self) -> Rotation {
        self.start
    }

    /// Height of a point above the ground, m, and the ground's normal there.
    pub fn height(&self, point: Vector) -> (f64, Vector) {
        let above = |plane: Plane| (plane.normal.dot(point) - plane.offset, plane.normal);
        let [first, second] = self.planes.map(above);
        let nearer = if (first.0 <= second.0) == self.valley {
            first
        } else {
            second
        };
        match self.plateau.map(above) {
            Some(plateau) if plateau.0 > nearer.0 => plateau,
            _ => nearer,
        }
    }

    /// Height of the surface at a place (x and y), m.
    pub fn surface(&self, [x, y]: [f64; 2]) -> f64 {
        let on = |plane: &Plane| {
            (plane.offset - plane.normal.x * x - plane.normal.y * y) / plane.normal.z
        };
        let [first, second] = [on(&self.planes[0]), on(&self.planes[1])];
        let ground = if self.valley == (first > second) {
            first
        } else {
            second
        };
        match &self.plateau {
            Some(plateau) if on(plateau) < ground => on(plateau),
            _ => ground,
        }
    }
}
