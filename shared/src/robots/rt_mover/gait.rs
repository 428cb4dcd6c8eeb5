//! The step-up gait (Nakajima, Fig. 3) as a table: one wheel after the other goes onto the step. What its stages do is [`super::walk`].

use super::wheel::{WHEELS, Wheel};

/// The order of the steps: front left, front right, rear left, rear right.
pub const ORDER: [Wheel; 4] = WHEELS;

/// What the robot is doing.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Stage {
    /// Standing or driving as the operator asks; posture is held.
    #[default]
    Standing,
    /// Turning the body askew, by which all four steps keep a margin alike.
    Skewing,
    /// Driving straight at the step, the next axle parallel to it, until its wheels feel it.
    Seeking,
    /// Driving back to where a wheel has room to rise.
    Backing,
    /// Steering the other axle to its limit, which widens the support.
    Widening,
    /// Lifting a wheel.
    Lifting,
    /// Swinging it over the step.
    Swinging,
    /// Letting it down until it feels the ground.
    Landing,
    /// Letting the load spread over four wheels.
    Settling,
    /// Steering straight again.
    Straightening,
    /// All four wheels are on the step.
    Arrived,
    /// Something did not go as it should; all four wheels are on the ground.
    Stuck,
    /// As that, with a wheel that may be in the air and stays where it is.
    Stranded,
}

impl Stage {
    /// Whether a wheel may be in the air: from its lift until the ground has carried it for a while.
    pub fn lifts(self) -> bool {
        matches!(
            self,
            Self::Lifting | Self::Swinging | Self::Landing | Self::Settling | Self::Stranded
        )
    }
}

/// What ends a stage.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Event {
    /// The operator asks for the step.
    Asked,
    /// The operator acknowledges how it ended.
    Acknowledged,
    /// The stage's goal is reached.
    Reached,
    /// As that, and the margin allows the step that follows.
    Allowed,
    /// As that, and the margin does not.
    Refused,
    /// With a wheel in the air, the margin has become too small.
    Unsafe,
    /// The wheel that seemed to touch carries nothing.
    Airborne,
    /// The gait is given up.
    GivenUp,
    /// The axle's second wheel is next.
    Partner,
    /// The other axle is next.
    OtherAxle,
    /// No wheel is left.
    Last,
    /// The stage takes too long.
    Late,
}

/// From a stage, on an event, to the next stage. No other way leads anywhere; in particular only [`Event::Allowed`] lifts a wheel.
pub const TABLE: [(Stage, Event, Stage); 37] = [
    (Stage::Standing, Event::Asked, Stage::Skewing),
    (Stage::Skewing, Event::Reached, Stage::Seeking),
    (Stage::Skewing, Event::Late, Stage::Stuck),
    (Stage::Seeking, Event::Reached, Stage::Backing),
    (Stage::Seeking, Event::Late, Stage::Stuck),
    (Stage::Backing, Event::Reached, Stage::Widening),
    (Stage::Backing, Event::Late, Stage::Stuck),
    (Stage::Widening, Event::Allowed, Stage::Lifting),
    (Stage::Widening, Event::Refused, Stage::Stuck),
    (Stage::Widening, Event::Late, Stage::Stuck),
    (Stage::Lifting, Event::Reached, Stage::Swinging),
    (Stage::Lifting, Event::Unsafe, Stage::Landing),
    (Stage::Lifting, Event::Late, Stage::Landing),
    (Stage::Swinging, Event::Reached, Stage::Landing),
    (Stage::Swinging, Event::Unsafe, Stage::Landing),
    (Stage::Swinging, Event::Late, Stage::Landing),
    (Stage::Landing, Event::Reached, Stage::Settling),
    (Stage::Landing, Event::Late, Stage::Stranded),
    (Stage::Settling, Event::Airborne, Stage::Landing),
    (Stage::Settling, Event::Partner, Stage::Widening),
    (Stage::Settling, Event::OtherAxle, Stage::Seeking),
    (Stage::Settling, Event::Last, Stage::Straightening),
    (Stage::Settling, Event::Refused, Stage::Stuck),
    (Stage::Straightening, Event::Reached, Stage::Arrived),
    (Stage::Straightening, Event::Late, Stage::Stuck),
    (Stage::Arrived, Event::Acknowledged, Stage::Standing),
    (Stage::Stuck, Event::Acknowledged, Stage::Standing),
    (Stage::Stranded, Event::Acknowledged, Stage::Landing),
    (Stage::Skewing, Event::GivenUp, Stage::Stuck),
    (Stage::Seeking, Event::GivenUp, Stage::Stuck),
    (Stage::Backing, Event::GivenUp, Stage::Stuck),
    (Stage::Widening, Event::GivenUp, Stage::Stuck),
    (Stage::Lifting, Event::GivenUp, Stage::Stranded),
    (Stage::Swinging, Event::GivenUp, Stage::Stranded),
    (Stage::Landing, Event::GivenUp, Stage::Stranded),
    (Stage::Settling, Event::GivenUp, Stage::Stranded),
    (Stage::Straightening, Event::GivenUp, Stage::Stuck),
];

/// Where `stage` goes on `event`; itself if the table has nothing.
pub fn next(stage: Stage, event: Event) -> Stage {
    TABLE
        .iter()
        .find(|(from, on, _)| (*from, *on) == (stage, event))
        .map_or(stage, |(_, _, to)| *to)
}
