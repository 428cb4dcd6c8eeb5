//! A hand that lifts, tilts and turns a robot: the path of the body that it holds.
//!
//! The hand is as strong as it has to be. While it holds the body, the body follows the path,
//! whatever the ground and the robot's other parts do.

use super::physics::{DT, turn};
use rapier3d_f64::math::{Pose, Vector};
use rapier3d_f64::prelude::*;

/// Time constant with which the body follows the path, s. The body may be off the path when the
/// hand takes hold of it.
const GRIP: f64 = 0.02;

/// Posture in which the hand holds the body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Held {
    /// Height above the place at which the hand took hold of the body, m.
    pub height: f64,
    /// Pitch (nose up positive), roll (left side up positive) and heading (counter-clockwise), rad,
    /// as in [`super::truth::Truth`].
    pub pitch: f64,
    /// See [`Self::pitch`].
    pub roll: f64,
    /// See [`Self::pitch`].
    pub heading: f64,
}

/// One motion of the hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Time at which it begins, s.
    pub begin_s: f64,
    /// Time at which it ends, s.
    pub end_s: f64,
    /// Posture at its end.
    pub to: Held,
}

/// Path of the hand. The hand takes hold of the body when the first motion begins, stays where a
/// motion ends until the next one begins, and lets go when the last one ends.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path(Vec<Motion>);

impl Path {
    /// Creates the path of these motions, in the order of their times.
    pub fn new(motions: Vec<Motion>) -> Self {
        Self(motions)
    }

    /// Posture in which the hand holds the body at this time; `None` if it does not.
    pub fn at(&self, time_s: f64) -> Option<Held> {
        if self.0.last().is_none_or(|last| time_s >= last.end_s) {
            return None;
        }
        let next = self.0.partition_point(|motion| motion.begin_s <= time_s);
        let motion = self.0.get(next.checked_sub(1)?)?;
        let from = next
            .checked_sub(2)
            .and_then(|before| self.0.get(before))
            .map_or_else(Held::default, |before| before.to);
        let done = (time_s - motion.begin_s) / (motion.end_s - motion.begin_s);
        let done = smooth(done.min(1.0));
        let between = |from: f64, to: f64| from + (to - from) * done;
        let to = motion.to;
        Some(Held {
            height: between(from.height, to.height),
            pitch: between(from.pitch, to.pitch),
            roll: between(from.roll, to.roll),
            heading: between(from.heading, to.heading),
        })
    }
}

/// Rises from 0 to 1 without a jump of speed or acceleration.
fn smooth(done: f64) -> f64 {
    done * done * done * (10.0 - done * (15.0 - 6.0 * done))
}

/// A body that a hand can hold.
#[derive(Clone, Copy, Debug, Default)]
pub struct Grip {
    /// Place of the body when the hand took hold of it.
    place: Option<Vector>,
}

impl Grip {
    /// Moves the body towards its posture in the next step; without a posture, lets go of it.
    pub fn hold(&mut self, body: &mut RigidBody, held: Option<&Held>) {
        let Some(held) = held else {
            if self.place.take().is_some() {
                body.set_body_type(RigidBodyType::Dynamic, true);
            }
            return;
        };
        let now = *body.position();
        let place = *self.place.get_or_insert(now.translation);
        body.set_body_type(RigidBodyType::KinematicPositionBased, true);
        let to = Pose::from_parts(
            place + Vector::Z * held.height,
            turn(Vector::Z, held.heading)
                * turn(Vector::X, held.roll)
                * turn(Vector::NEG_Y, held.pitch),
        );
        let followed = DT / (GRIP + DT);
        body.set_next_kinematic_position(Pose::from_parts(
            now.translation + (to.translation - now.translation) * followed,
            now.rotation.lerp(to.rotation, followed),
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hand_holds_from_its_first_motion_to_the_end_of_its_last_one() {
        let to = |height: f64, pitch: f64| Held {
            height,
            pitch,
            ..Held::default()
        };
        let motion = |begin_s: f64, to: Held| Motion {
            begin_s,
            end_s: begin_s + 2.0,
            to,
        };
        let path = Path::new(vec![motion(1.0, to(0.4, 0.2)), motion(5.0, to(0.0, 0.2))]);
        assert_eq!(path.at(0.99), None);
        assert_eq!(path.at(1.0), Some(Held::default()));
        assert_eq!(path.at(2.0), Some(to(0.2, 0.1)));
        for resting in [3.0, 4.0, 5.0] {
            assert_eq!(path.at(resting), Some(to(0.4, 0.2)));
        }
        assert_eq!(path.at(6.0), Some(to(0.2, 0.2)));
        assert_eq!(path.at(7.0), None);
        assert_eq!(Path::default().at(1.0), None);
    }
}
