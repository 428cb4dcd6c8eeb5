//! Decides whether a robot that topples fell over an edge, or toppled on fair ground. Fair ground
//! is ground on which the guard must keep the robot upright.
//!
//! The rule, in the simulator's ground truth:
//! * Every place where the ground drops is an edge with a higher and a lower side. The noses of
//!   stairs and the front of a curb can be climbed. Side edges, the far end of a landing and the
//!   border of the ground cannot.
//! * The robot climbs an edge when its centre of gravity crosses it upward where it can be climbed.
//!   From then on the edge is fair ground.
//! * The robot falls when its centre of gravity crosses an edge downward that it has not climbed.
//!   The fall ends when the centre of gravity comes back over that edge, or when all contacts with
//!   the ground have been on the lower side, farther than 2 cm from the edge, for one second.
//! * Beyond the border of the ground there is nothing, and a wheel that leaves it tips the robot
//!   before the centre of gravity reaches the border. So a contact that touches the border also
//!   counts as a fall, until one second after the last touch.
//! * A robot that turns over during a fall toppled over an edge. Every other topple is on fair
//!   ground.
//!
//! A robot that climbs a side edge from below and topples there topples on fair ground, because it
//! crossed no edge downward.

use crate::scenario::Description;
use crate::world::ground::Ground;
use crate::world::truth::Truth;

/// A contact closer to an edge than this touches it, m.
const TOUCHES: f64 = 0.02;
/// Time on the lower side after which a fall ends, s.
const FALL_ENDS_S: f64 = 1.0;

/// A straight edge along one of the ground's axes.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Edge {
    /// Axis that is perpendicular to the edge: 0 is x, 1 is y.
    across: usize,
    /// Coordinate of the edge on that axis, m.
    at: f64,
    /// Beginning and end of the edge on the other axis, m.
    reach: [f64; 2],
    /// 1 if the higher side has the larger coordinate, else -1.
    high: f64,
    /// Whether the robot can climb it.
    climbable: bool,
    /// Whether the ground ends here.
    border: bool,
}

impl Edge {
    /// Distance from the edge, positive on the higher side, m.
    fn height_side(&self, place: [f64; 2]) -> f64 {
        (place[self.across] - self.at) * self.high
    }

    /// Whether the straight line between two places crosses the edge: 1 upward, -1 downward, 0 not
    /// at all.
    fn crossing(&self, from: [f64; 2], to: [f64; 2]) -> i32 {
        let (before, after) = (self.height_side(from), self.height_side(to));
        if (before >= 0.0) == (after >= 0.0) {
            return 0;
        }
        let along = 1 - self.across;
        let share = before / (before - after);
        let place = from[along] + share * (to[along] - from[along]);
        if place < self.reach[0] || place > self.reach[1] {
            0
        } else if after >= 0.0 {
            1
        } else {
            -1
        }
    }
}

/// A fall that has begun.
#[derive(Clone, Copy, Debug)]
struct Fall {
    edge: usize,
    /// Time since which all contacts have been on the lower side, s.
    below_since_s: Option<f64>,
}

/// Follows a run and tracks whether the robot is falling over an edge that it did not climb.
#[derive(Clone, Debug)]
pub struct Edges {
    ground: Vec<Edge>,
    climbed: Vec<bool>,
    place: Option<[f64; 2]>,
    fall: Option<Fall>,
    /// Time until which the last touch of the border counts as a fall, s.
    at_border_until_s: f64,
    now_s: f64,
}

impl Edges {
    /// The edges of a scenario's ground, none of them climbed.
    pub fn of(scenario: &Description) -> Self {
        let own = scenario.robot.section().extent(&scenario.terrain);
        let edges = own.map_or_else(|| edges(&scenario.terrain.ground()), border);
        Self {
            climbed: vec![false; edges.len()],
            ground: edges,
            place: None,
            fall: None,
            at_border_until_s: f64::NEG_INFINITY,
            now_s: 0.0,
        }
    }

    /// Processes the next sample of the run. Samples must be in order of time.
    pub fn follow(&mut self, time_s: f64, truth: &Truth) {
        let now = [truth.cog[0], truth.cog[1]];
        let before = self.place.replace(now).unwrap_or(now);
        for (index, edge) in self.ground.iter().enumerate() {
            match edge.crossing(before, now) {
                1 => {
                    self.climbed[index] |= edge.climbable;
                    self.fall = self.fall.filter(|fall| fall.edge != index);
                }
                -1 if !self.climbed[index] => {
                    self.fall = Some(Fall {
                        edge: index,
                        below_since_s: None,
                    });
                }
                _ => {}
            }
        }
        self.now_s = time_s;
        let touches = |edge: &Edge| {
            let mut contacts = truth.contacts.iter();
            edge.border && contacts.any(|[x, y, _]| edge.height_side([*x, *y]) < TOUCHES)
        };
        if self.ground.iter().any(touches) {
            self.at_border_until_s = time_s + FALL_ENDS_S;
        }
        let Some(fall) = &mut self.fall else { return };
        let edge = self.ground[fall.edge];
        let below = |point: &[f64; 3]| edge.height_side([point[0], point[1]]) < -TOUCHES;
        let stands = !truth.contacts.is_empty() && truth.contacts.iter().all(below);
        fall.below_since_s = stands.then(|| fall.below_since_s.unwrap_or(time_s));
        let over = |since: f64| time_s - since >= FALL_ENDS_S;
        if fall.below_since_s.is_some_and(over) {
            self.fall = None;
        }
    }

    /// Whether the robot is falling over an edge that is not fair ground.
    pub fn falling(&self) -> bool {
        self.fall.is_some() || self.now_s < self.at_border_until_s
    }
}

fn edges(ground: &Ground) -> Vec<Edge> {
    let across_x = |at, half_width: f64, high, climbable| Edge {
        across: 0,
        at,
        reach: [-half_width, half_width],
        high,
        climbable,
        border: false,
    };
    match *ground {
        Ground::Stairs(stairs) => {
            let half_width = 0.5 * stairs.width;
            let up = if stairs.down { -1.0 } else { 1.0 };
            let nose = |i: usize| {
                let at = stairs.first_nose_x + stairs.run * i as f64;
                across_x(at, half_width, up, !stairs.down)
            };
            let mut edges: Vec<_> = (0..stairs.count).map(nose).collect();
            let (end, reach) = if stairs.down {
                let back = stairs.first_nose_x - stairs.landing;
                (back, [back, stairs.last_nose_x()])
            } else {
                let end = stairs.last_nose_x() + stairs.landing;
                (end, [stairs.first_nose_x, end])
            };
            edges.push(across_x(end, half_width, -up, false));
            edges.extend([1.0, -1.0].map(|side| Edge {
                across: 1,
                at: side * half_width,
                reach,
                high: -side,
                climbable: false,
                border: false,
            }));
            edges
        }
        Ground::Curb { front_x, depth, .. } => vec![
            across_x(front_x, f64::INFINITY, 1.0, true),
            across_x(front_x + depth, f64::INFINITY, -1.0, false),
        ],
        // The plateau behind a ramp ends after 20 m, which no run of the suite reaches.
        Ground::Flat | Ground::Ramp { .. } | Ground::Incline { .. } => Vec::new(),
    }
}

/// The border of a piece of ground, given as ranges of x and y. Beyond it there is nothing.
fn border(extent: [[f64; 2]; 2]) -> Vec<Edge> {
    let side = |across: usize, end: usize| Edge {
        across,
        at: extent[across][end],
        reach: extent[1 - across],
        high: if end == 0 { 1.0 } else { -1.0 },
        climbable: false,
        border: true,
    };
    vec![side(0, 0), side(0, 1), side(1, 0), side(1, 1)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::ground::Stairs;

    /// Stairs two metres wide, with noses at 1.5, 1.78 and 2.06 m; the landing ends at 5.06 m.
    fn stairs(down: bool) -> Edges {
        let stairs = Stairs {
            count: 3,
            landing: 3.0,
            down,
            ..Stairs::paper()
        };
        with(edges(&Ground::Stairs(stairs)))
    }

    fn with(edges: Vec<Edge>) -> Edges {
        Edges {
            climbed: vec![false; edges.len()],
            ground: edges,
            place: None,
            fall: None,
            at_border_until_s: f64::NEG_INFINITY,
            now_s: 0.0,
        }
    }

    /// Whether the robot falls at the end of a path, with contacts 0.1 m in front of and behind its
    /// centre of gravity.
    fn falls(edges: &mut Edges, way: &[[f64; 2]]) -> bool {
        for (index, [x, y]) in way.iter().enumerate() {
            follow(
                edges,
                0.01 * index as f64,
                [*x, *y],
                &[[*x - 0.1, *y, 0.0], [*x + 0.1, *y, 0.0]],
            );
        }
        edges.falling()
    }

    fn follow(edges: &mut Edges, time_s: f64, place: [f64; 2], contacts: &[[f64; 3]]) {
        let truth = Truth {
            cog: [place[0], place[1], 0.3],
            contacts: contacts.to_vec(),
            ..Truth::default()
        };
        edges.follow(time_s, &truth);
    }

    #[test]
    fn backward_down_stairs_that_the_robot_climbed_is_fair_ground() {
        let way = [
            [1.0, 0.0],
            [1.6, 0.0],
            [1.9, 0.0],
            [2.3, 0.0],
            [1.9, 0.0],
            [1.0, 0.0],
        ];
        assert!(!falls(&mut stairs(false), &way));
    }

    #[test]
    fn over_a_side_edge_or_the_end_of_the_landing_is_not() {
        let up = [[1.0, 0.0], [1.6, 0.0], [1.9, 0.0], [2.3, 0.0]];
        for last in [[2.3, 1.1], [2.3, -1.1], [5.2, 0.0]] {
            let mut way = up.to_vec();
            way.push(last);
            assert!(falls(&mut stairs(false), &way), "to {last:?}");
        }
        // Beside the stairs the ground does not drop.
        assert!(!falls(
            &mut stairs(false),
            &[[1.0, 0.0], [1.0, 1.5], [3.0, 1.5]]
        ));
    }

    #[test]
    fn stairs_that_the_robot_came_upon_from_the_side_or_from_above_are_not() {
        let from_aside = [[1.65, 1.5], [1.65, 0.0], [1.2, 0.0]];
        assert!(falls(&mut stairs(false), &from_aside));
        assert!(falls(&mut stairs(true), &[[0.0, 0.0], [1.6, 0.0]]));
    }

    #[test]
    fn a_topple_on_the_stairs_is_no_fall() {
        // The robot topples backward on the stairs, or rears up against their side from below.
        let back = [[1.0, 0.0], [1.6, 0.0], [1.9, 0.0], [1.7, 0.0]];
        assert!(!falls(&mut stairs(false), &back));
        assert!(!falls(
            &mut stairs(false),
            &[[2.0, 1.5], [2.0, 1.05], [2.0, 1.4]]
        ));
    }

    #[test]
    fn a_fall_ends_on_the_way_back_or_after_a_second_below_and_not_while_the_edge_is_touched() {
        let edge = || {
            with(edges(&Ground::Curb {
                height: 0.1,
                front_x: 1.0,
                depth: 2.0,
            }))
        };
        let over = [[0.5, 0.0], [2.0, 0.0], [3.1, 0.0]];
        let mut back = over.to_vec();
        back.push([2.9, 0.0]);
        assert!(!falls(&mut edge(), &back));
        for (contact_x, ends) in [(3.01, false), (3.05, true)] {
            let mut edges = edge();
            assert!(falls(&mut edges, &over));
            for step in 0..110 {
                let contacts = [[contact_x, 0.0, 0.0], [3.5, 0.0, 0.0]];
                follow(
                    &mut edges,
                    1.0 + 0.01 * f64::from(step),
                    [3.2, 0.0],
                    &contacts,
                );
            }
            assert_eq!(edges.falling(), !ends, "contact at {contact_x}");
        }
    }

    #[test]
    fn the_border_of_the_ground_is_an_edge_on_all_four_sides() {
        for last in [[6.1, 0.0], [-6.1, 0.0], [0.0, 8.1], [0.0, -4.1]] {
            let mut edges = with(border([[-6.0, 6.0], [-4.0, 8.0]]));
            assert!(falls(&mut edges, &[[0.0, 0.0], last]), "to {last:?}");
        }
    }

    /// A wheel reaches the border 0.4 m before the centre of gravity does.
    #[test]
    fn a_wheel_at_the_border_is_a_fall_until_a_second_after_it_was_last_there() {
        let mut edges = with(border([[-6.0, 6.0], [-4.0, 8.0]]));
        let mut at = |time_s: f64, wheel_y: f64| {
            let contacts = [[0.0, wheel_y, 0.0], [0.3, -3.2, 0.0]];
            follow(&mut edges, time_s, [0.0, -3.6], &contacts);
            edges.falling()
        };
        assert!(!at(0.0, -3.9));
        assert!(at(0.1, -3.99));
        assert!(at(0.2, -4.03));
        assert!(at(1.1, -3.5));
        assert!(!at(1.3, -3.5));
    }
}
