//! Defines the step-up gait (Nakajima, Fig. 3) as a table of stages: one wheel after the other goes
//! onto the step. [`super::walk`] carries the stages out.

use super::wheel::{WHEELS, Wheel};

/// Order in which the wheels step up: front left, front right, rear left, rear right.
pub const ORDER: [Wheel; 4] = WHEELS;

/// Stage of the gait.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Stage {
    /// Standing or driving as the operator commands; the posture is held.
    #[default]
    Standing,
    /// Turning the body askew, so that all four steps have similar margins.
    Skewing,
    /// Driving straight at the step, with the next axle parallel to it, until the wheels of this
    /// axle touch it.
    Seeking,
    /// Driving back until the wheel has room to rise.
    Backing,
    /// Steering the other axle to its limit, which widens the support.
    Widening,
    /// Lifting a wheel.
    Lifting,
    /// Swinging the wheel over the step.
    Swinging,
    /// Lowering the wheel until it touches the ground.
    Landing,
    /// Waiting until the load has spread over four wheels.
    Settling,
    /// Steering straight again.
    Straightening,
    /// All four wheels are on the step.
    Arrived,
    /// The gait failed; all four wheels are on the ground.
    Stuck,
    /// The gait failed; one wheel may be in the air and stays where it is.
    Stranded,
}

impl Stage {
    /// Whether a wheel may be in the air: from its lift until the ground has carried it for a
    /// while.
    pub fn lifts(self) -> bool {
        matches!(
            self,
            Self::Lifting | Self::Swinging | Self::Landing | Self::Settling | Self::Stranded
        )
    }
}

/// Event that ends a stage.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Event {
    /// The operator commands a step.
    Commanded,
    /// The operator acknowledges how the gait ended.
    Acknowledged,
    /// The stage's goal is reached.
    Reached,
    /// The stage's goal is reached, and the predicted margin allows the next step.
    Allowed,
    /// The stage's goal is reached, but the next step is not allowed: the prediction refuses it, or
    /// a step was broken off before.
    Refused,
    /// The margin has become too small while a wheel is in the air.
    Unsafe,
    /// The wheel that seemed to touch carries no load.
    Airborne,
    /// The gait is aborted.
    GivenUp,
    /// The second wheel of the axle is next.
    Partner,
    /// The other axle is next.
    OtherAxle,
    /// No wheel is left.
    Last,
    /// The stage has exceeded its timeout.
    Late,
}

/// Transitions from a stage, on an event, to the next stage. There are no others; in particular,
/// only [`Event::Allowed`] leads to the lifting of a wheel.
pub const TABLE: [(Stage, Event, Stage); 37] = [
    (Stage::Standing, Event::Commanded, Stage::Skewing),
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

/// Next stage after `stage` on `event`; `stage` itself if the table has no such transition.
pub fn next(stage: Stage, event: Event) -> Stage {
    TABLE
        .iter()
        .find(|(from, on, _)| (*from, *on) == (stage, event))
        .map_or(stage, |(_, _, to)| *to)
}
