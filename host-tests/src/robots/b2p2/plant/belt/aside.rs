//! Computes the forces with which the corners of the ground hold a free span sideways.
//!
//! The belt sticks to a corner by friction. If the robot moves sideways, the span bends in its own
//! surface like a beam on two supports, its pulleys, until the friction is used up; then the belt
//! slides (the friction model of Dahl).

use super::path::{Bend, Path};
use super::tension::{LEAD, Touch};
use crate::world::physics::DT;
use rapier3d_f64::glamx::DVec2;

/// Shortest length of a span on either side of a corner that bends, m. A shorter one would need a
/// shorter step.
const SHORTEST: f64 = 0.05;

/// The free span over a corner.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// Pulleys behind and before the corner.
    pub between: [Bend; 2],
    /// Where the belt leaves the one and reaches the other, m.
    pub ends: [DVec2; 2],
    /// Distances from the corner to these places, m.
    apart: [f64; 2],
}

impl Span {
    /// Finds the span over the corner at which straight piece `index` of `path` ends.
    pub fn over(path: &Path, index: usize) -> Option<Self> {
        let (before, behind) = path.straights.split_at_checked(index + 1)?;
        let pulley = |bend: &Bend| matches!(bend, Bend::Pulley(_));
        let from = before.iter().rfind(|piece| pulley(&piece.between[0]))?;
        let to = behind.iter().find(|piece| pulley(&piece.between[1]))?;
        let place = before.last()?.ends[1];
        let ends = [from.ends[0], to.ends[1]];
        Some(Self {
            between: [from.between[0], to.between[1]],
            ends,
            apart: ends.map(|end| end.distance(place).max(SHORTEST)),
        })
    }

    /// Parts of a force at the corner that the two pulleys bear.
    pub fn parts(&self) -> [f64; 2] {
        let [behind, before] = self.apart;
        [before, behind].map(|arm| arm / (behind + before))
    }

    /// Force that bends the belt aside by one metre at the corner, N/m. `rigidity` is its bending
    /// stiffness, N m^2.
    fn stiffness(&self, rigidity: f64) -> f64 {
        let [behind, before] = self.apart;
        3.0 * rigidity * (behind + before) / (behind * behind * before * before)
    }
}

/// How far the corners bend one belt aside.
#[derive(Clone, Debug, Default)]
pub struct Aside {
    /// Bending stiffness of the belt in its surface, N m^2.
    pub rigidity: f64,
    /// Corners that touch the belt, with the way of the robot to the left since the belt stuck, m.
    corners: Vec<(usize, f64)>,
}

impl Aside {
    /// Forgets the corners that do not touch the belt any more.
    pub fn keep(&mut self, touches: &[Touch]) {
        let touching = |edge| touches.iter().any(|touch| touch.corner.edge == edge);
        self.corners.retain(|(edge, _)| touching(*edge));
    }

    /// Returns the force of a corner on the robot, to the left, N. `speed` is that of the robot
    /// over the corner, to the left, m/s, and `most` the largest friction, N.
    pub fn force(&mut self, touch: &Touch, span: &Span, speed: f64, most: f64) -> f64 {
        let edge = touch.corner.edge;
        let index = self.corners.iter().position(|(known, _)| *known == edge);
        let index = index.unwrap_or_else(|| {
            self.corners.push((edge, 0.0));
            self.corners.len() - 1
        });
        let way = &mut self.corners[index].1;
        let stiffness = span.stiffness(self.rigidity);
        let sliding = libm::sqrt(speed * speed + touch.sliding * touch.sliding) * DT;
        // More than zero, for a belt that nothing presses.
        let most_way = (most / stiffness).max(1e-9);
        // Implicit in the sliding, so that no step is too long.
        *way = (*way + speed * DT) / (1.0 + sliding / most_way);
        *way = way.clamp(-most_way, most_way);
        (-stiffness * (*way + LEAD * speed)).clamp(-most, most)
    }
}

#[cfg(test)]
mod tests {
    use super::super::path::{Corner, Pulleys};
    use super::*;

    /// A corner in the middle of a span of 0.6 m, and what touches there.
    fn middle(sliding: f64) -> (Span, Touch) {
        let pulleys = Pulleys {
            axles: [DVec2::ZERO, DVec2::new(0.3, 0.2), DVec2::new(0.6, 0.0)],
            radius: 0.05,
        };
        let place = DVec2::new(0.3, -0.03);
        let corner = Corner { edge: 4, place };
        let path = Path::around(&pulleys, &[corner], true);
        let span = Span::over(&path, 0).expect("a span");
        (span, Touch { corner, sliding })
    }

    fn belt() -> Aside {
        Aside {
            rigidity: 20.0,
            ..Aside::default()
        }
    }

    #[test]
    fn a_belt_bends_like_a_beam_until_it_slides() {
        let (span, touch) = middle(0.0);
        let mut aside = belt();
        // 48 E I / l^3 of a beam of about 0.6 m.
        let stiffness = 48.0 * 20.0 / 0.6_f64.powi(3);
        let slow = 0.001;
        let after = |aside: &mut Aside, seconds: f64, speed: f64| {
            (0..(seconds / DT) as usize)
                .map(|_| aside.force(&touch, &span, speed, 200.0))
                .last()
                .unwrap()
        };
        let force = after(&mut aside, 1.0, slow);
        assert!((force / (-stiffness * 0.001) - 1.0).abs() < 0.04, "{force}");
        let force = after(&mut aside, 1.0, 1.0);
        assert!((force + 200.0).abs() < 0.5, "{force}");
        // It holds what it has bent, also against a robot at rest.
        let force = after(&mut aside, 1.0, 0.0);
        assert!((force + 200.0).abs() < 5.0, "{force}");
        assert_eq!(span.parts(), [0.5, 0.5]);
    }

    #[test]
    fn a_belt_that_slides_along_its_way_holds_nothing_sideways() {
        let (span, touch) = middle(0.5);
        let mut aside = belt();
        let forces: Vec<f64> = (0..1000)
            .map(|_| aside.force(&touch, &span, 0.05, 200.0))
            .collect();
        // Friction acts against the direction of sliding: 0.05 of 0.5 m/s.
        let sideways = 200.0 * 0.05 / 0.5;
        assert!(
            (forces[999] / -sideways - 1.0).abs() < 0.1,
            "{}",
            forces[999]
        );
        aside.keep(&[]);
        let force = aside.force(&touch, &span, 0.0, 200.0);
        assert_eq!(force, 0.0);
    }
}
