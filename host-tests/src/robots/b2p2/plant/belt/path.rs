//! Computes the path of a belt: the shortest loop around the three pulleys and over the corners of
//! the ground that push it inward.
//!
//! Everything is in the plane of the belt, in the axes of segment 1: x forward, z up, the origin on
//! axle 1. The path begins at the lowest point of pulley 1, leads forward below the pulleys, around
//! pulley 3, and back above them to the highest point of pulley 1. So the pulleys are on its left,
//! and the corners on its right. The rear half of pulley 1, which does not change, is no part of
//! it.

use core::f64::consts::PI;
use core::ops::Range;
use rapier3d_f64::glamx::DVec2;

/// Corner of the ground in the plane of a belt.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Corner {
    /// Number of the edge of the ground to which it belongs.
    pub edge: usize,
    /// Place, m.
    pub place: DVec2,
}

/// What the belt bends around.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Bend {
    /// Pulley on axle 1, 2 or 3 (0, 1, 2).
    Pulley(usize),
    /// Corner of the ground.
    Corner(Corner),
}

/// Straight piece of the belt.
#[derive(Clone, Copy, Debug)]
pub struct Straight {
    /// What it leaves, and what it reaches.
    pub between: [Bend; 2],
    /// Where it leaves and where it arrives, m.
    pub ends: [DVec2; 2],
    /// Direction, of length 1.
    pub direction: DVec2,
    /// Length, m.
    pub length: f64,
}

/// Posture of the pulleys.
#[derive(Clone, Copy, Debug)]
pub struct Pulleys {
    /// Places of axles 1 to 3, m.
    pub axles: [DVec2; 3],
    /// Radius of the pulleys with their belt, m.
    pub radius: f64,
}

/// Path of a belt.
#[derive(Clone, Debug, Default)]
pub struct Path {
    /// The straight pieces, in the order of the path.
    pub straights: Vec<Straight>,
}

impl Path {
    /// Computes the path around `pulleys`.
    ///
    /// With `guided`, guide plates carry the belt between pulleys 1 and 2 and between 2 and 3, so
    /// corners push it inward only where it leads directly from pulley 1 to pulley 3. Axle 3 must
    /// be at another place than axles 1 and 2.
    pub fn around(pulleys: &Pulleys, corners: &[Corner], guided: bool) -> Self {
        let [first, second, third] = pulleys.axles;
        let mut path = Self::default();
        // The side of the line from axle 1 to axle 3 on which axle 2 lies.
        let above = (third - first).perp_dot(second - first) > 0.0;
        if above {
            path.span(pulleys, [0, 2], corners);
            path.span(pulleys, [2, 1], &[]);
            path.span(pulleys, [1, 0], &[]);
        } else {
            let corners = if guided { &[] } else { corners };
            path.span(pulleys, [0, 1], corners);
            path.span(pulleys, [1, 2], corners);
            path.span(pulleys, [2, 0], &[]);
        }
        path
    }

    /// Adds the span between two pulleys. It goes from bend to bend, always to the one whose
    /// direction is farthest to the left; so it is the shortest path over the corners.
    fn span(&mut self, pulleys: &Pulleys, [from, to]: [usize; 2], corners: &[Corner]) {
        let direct = between_pulleys(pulleys, [from, to]);
        let along = |point: DVec2| (point - direct.ends[0]).dot(direct.direction);
        let (mut bend, mut passed) = (Bend::Pulley(from), 0.0);
        loop {
            let mut best = match bend {
                Bend::Pulley(_) => direct,
                Bend::Corner(corner) => to_pulley(corner, pulleys, to),
            };
            for corner in corners {
                let ahead = along(corner.place);
                let beside = direct.direction.perp_dot(corner.place - direct.ends[0]);
                let outside = [from, to]
                    .into_iter()
                    .all(|pulley| pulleys.axles[pulley].distance(corner.place) > pulleys.radius);
                if !(ahead > passed && ahead < direct.length && beside > 0.0 && outside) {
                    continue;
                }
                let next = match bend {
                    Bend::Pulley(_) => from_pulley(pulleys, from, *corner),
                    Bend::Corner(last) => between_corners(last, *corner),
                };
                if best.direction.perp_dot(next.direction) > 0.0 {
                    best = next;
                }
            }
            self.straights.push(best);
            bend = best.between[1];
            match bend {
                Bend::Pulley(_) => return,
                Bend::Corner(corner) => passed = along(corner.place),
            }
        }
    }

    /// Corners around which the path bends, from the first to the last.
    pub fn corners(&self) -> impl Iterator<Item = &Corner> {
        self.straights
            .iter()
            .filter_map(|straight| match &straight.between[1] {
                Bend::Corner(corner) => Some(corner),
                Bend::Pulley(_) => None,
            })
    }

    /// Length on pulleys of this radius, m.
    pub fn length(&self, radius: f64) -> f64 {
        let sections = self.sections();
        sections.iter().map(|section| section.length(radius)).sum()
    }

    /// Splits the path at the corners. The first section begins at the lowest point of pulley 1,
    /// and the last one ends at the highest point.
    pub fn sections(&self) -> Vec<Section> {
        let mut sections = vec![Section::default()];
        let mut direction = DVec2::X;
        for (index, straight) in self.straights.iter().enumerate() {
            let turned = angle(direction, straight.direction);
            let at = sections.len() - 1;
            let present = &mut sections[at];
            match straight.between[0] {
                Bend::Pulley(_) => present.turned += left_turn(turned),
                Bend::Corner(corner) => {
                    present.ends_at = Some((corner, -turned));
                    sections.push(Section {
                        straights: index..index,
                        ..Section::default()
                    });
                }
            }
            let at = sections.len() - 1;
            let present = &mut sections[at];
            present.straight += straight.length;
            present.straights.end = index + 1;
            direction = straight.direction;
        }
        if let Some(last) = sections.last_mut() {
            last.turned += left_turn(angle(direction, DVec2::NEG_X));
        }
        sections
    }
}

/// Section of a path between two corners, or between pulley 1 and a corner.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Section {
    /// Its straight pieces.
    pub straights: Range<usize>,
    /// Sum of their lengths, m.
    pub straight: f64,
    /// Angle by which it turns on pulleys, rad.
    pub turned: f64,
    /// Corner at which it ends, and the angle by which the belt bends around it, rad. The last
    /// section has none.
    pub ends_at: Option<(Corner, f64)>,
}

impl Section {
    /// Length on pulleys of this radius, m.
    pub fn length(&self, radius: f64) -> f64 {
        self.straight + self.turned * radius
    }
}

/// Angle from `from` to `to`, counter-clockwise, from -pi to pi, rad.
fn angle(from: DVec2, to: DVec2) -> f64 {
    libm::atan2(from.perp_dot(to), from.dot(to))
}

/// The same angle as a belt turns around a pulley: by up to three quarters of a turn.
fn left_turn(angle: f64) -> f64 {
    if angle < -0.5 * PI {
        angle + 2.0 * PI
    } else {
        angle
    }
}

/// Direction to the right of `direction`.
fn right(direction: DVec2) -> DVec2 {
    DVec2::new(direction.y, -direction.x)
}

fn straight(between: [Bend; 2], ends: [DVec2; 2], direction: DVec2) -> Straight {
    let length = (ends[1] - ends[0]).dot(direction);
    Straight {
        between,
        ends,
        direction,
        length,
    }
}

/// Common tangent of two pulleys, which are both on its left.
fn between_pulleys(pulleys: &Pulleys, span: [usize; 2]) -> Straight {
    let [from, to] = span.map(|pulley| pulleys.axles[pulley]);
    let direction = (to - from).normalize();
    let aside = right(direction) * pulleys.radius;
    straight(
        span.map(Bend::Pulley),
        [from + aside, to + aside],
        direction,
    )
}

fn between_corners(from: Corner, to: Corner) -> Straight {
    let ends = [from.place, to.place];
    let direction = (to.place - from.place).normalize();
    straight([from, to].map(Bend::Corner), ends, direction)
}

/// Tangent from a pulley, which is on its left, to a corner outside of the pulley.
fn from_pulley(pulleys: &Pulleys, pulley: usize, corner: Corner) -> Straight {
    let centre = pulleys.axles[pulley];
    let direction = tangent(corner.place - centre, pulleys.radius);
    let leaves = centre + right(direction) * pulleys.radius;
    let between = [Bend::Pulley(pulley), Bend::Corner(corner)];
    straight(between, [leaves, corner.place], direction)
}

/// Tangent from a corner outside of a pulley to the pulley, which is on its left.
fn to_pulley(corner: Corner, pulleys: &Pulleys, pulley: usize) -> Straight {
    let centre = pulleys.axles[pulley];
    let direction = tangent(centre - corner.place, -pulleys.radius);
    let arrives = centre + right(direction) * pulleys.radius;
    let between = [Bend::Corner(corner), Bend::Pulley(pulley)];
    straight(between, [corner.place, arrives], direction)
}

/// Direction of a line that covers `way`, whose part across the line is `aside` to the right.
fn tangent(way: DVec2, aside: f64) -> DVec2 {
    let square = way.length_squared();
    let along = libm::sqrt(square - aside * aside);
    DVec2::new(way.x * along - way.y * aside, way.y * along + way.x * aside) / square
}
