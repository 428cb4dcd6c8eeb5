//! The phases of an autonomous clearance, and the table of transitions between them.
//!
//! The paper has three areas in a climb: A1, the first step; A2, the middle steps; A3, the last
//! step. [`Phase::Reach`] and [`Phase::Mount`] are A1, [`Phase::Climb`] and [`Phase::Sway`] A2,
//! [`Phase::Crest`] and [`Phase::Land`] A3.

/// Phase of a clearance. The numbers are those of object 0x4015:1.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[repr(u8)]
pub enum Phase {
    /// The operator commands speed and posture.
    #[default]
    Off = 0,
    /// Straight on level ground.
    Approach = 1,
    /// Something lifts or stops the front: the front is raised.
    Reach = 2,
    /// A nose lies under the raised front: the front is lowered onto it.
    Mount = 3,
    /// Straight on noses, or on a ramp.
    Climb = 4,
    /// The centre of gravity has passed a nose, and the robot tilts forward.
    Sway = 5,
    /// The front found no further nose: it is lowered to meet the landing.
    Crest = 6,
    /// Behind an obstacle: the front is straightened.
    Land = 7,
    /// Down from an edge.
    Descend = 8,
    /// Back to level ground.
    Withdraw = 9,
    /// Given up on level ground: the robot stands until the operator requests anew.
    GivenUp = 10,
    /// Given up off level ground: the robot stands until the operator requests anew.
    Held = 11,
    /// Second attempt at an obstacle that is too high for taut belts: the front is raised.
    Raise = 12,
    /// The belts are released, and the front is folded: the robot stands over the nose as an arch.
    Arch = 13,
    /// The belts are taken up, and haul the robot over the nose.
    Haul = 14,
}

impl Phase {
    /// All phases, in the order of their numbers.
    pub const ALL: [Self; 15] = [
        Self::Off,
        Self::Approach,
        Self::Reach,
        Self::Mount,
        Self::Climb,
        Self::Sway,
        Self::Crest,
        Self::Land,
        Self::Descend,
        Self::Withdraw,
        Self::GivenUp,
        Self::Held,
        Self::Raise,
        Self::Arch,
        Self::Haul,
    ];

    /// Returns the phase with this number.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }

    /// Returns the name for reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Approach => "approach",
            Self::Reach => "reach",
            Self::Mount => "mount",
            Self::Climb => "climb",
            Self::Sway => "sway",
            Self::Crest => "crest",
            Self::Land => "land",
            Self::Descend => "descend",
            Self::Withdraw => "withdraw",
            Self::GivenUp => "given up",
            Self::Held => "held",
            Self::Raise => "raise",
            Self::Arch => "arch",
            Self::Haul => "haul",
        }
    }
}

/// Cause of a transition. The numbers are those of object 0x4015:2.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[repr(u8)]
pub enum Cause {
    /// There was no transition yet.
    #[default]
    None = 0,
    /// The operator requested it, or took over.
    Operator = 1,
    /// The front is lifted.
    FrontLifted = 2,
    /// The tracks push against something.
    TracksPush = 3,
    /// A nose lies under the raised front.
    NoseUnderFront = 4,
    /// The front is straight.
    Straight = 5,
    /// The centre of gravity has passed a nose.
    PastNose = 6,
    /// The next nose carries the front.
    NextNose = 7,
    /// No further nose carries the front.
    NothingAhead = 8,
    /// The front, or the whole robot, lies on level ground.
    Level = 9,
    /// The robot has landed.
    Landed = 10,
    /// The robot tilts forward over an edge.
    Edge = 11,
    /// The robot is steeper than the steepest pitch at which it can pass a nose.
    TooHigh = 12,
    /// The belts ran without progress.
    NoProgress = 13,
    /// The phase lasted too long.
    Timeout = 14,
    /// The robot is too steep nose down.
    TooSteep = 15,
    /// The guard tripped, or another stop ended the clearance.
    Stopped = 16,
    /// Nothing was there.
    Nothing = 17,
    /// The front lies on the obstacle, and the robot stands as an arch.
    OnTop = 18,
    /// The belts have hauled the robot over the nose.
    Hauled = 19,
    /// The robot has turned aside, as with one track that drives.
    Turned = 20,
}

impl Cause {
    /// All causes, in the order of their numbers.
    pub const ALL: [Self; 21] = [
        Self::None,
        Self::Operator,
        Self::FrontLifted,
        Self::TracksPush,
        Self::NoseUnderFront,
        Self::Straight,
        Self::PastNose,
        Self::NextNose,
        Self::NothingAhead,
        Self::Level,
        Self::Landed,
        Self::Edge,
        Self::TooHigh,
        Self::NoProgress,
        Self::Timeout,
        Self::TooSteep,
        Self::Stopped,
        Self::Nothing,
        Self::OnTop,
        Self::Hauled,
        Self::Turned,
    ];

    /// Returns the cause with this number.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }

    /// Returns the words for reports.
    pub fn words(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Operator => "operator",
            Self::FrontLifted => "front lifted",
            Self::TracksPush => "tracks push",
            Self::NoseUnderFront => "nose under front",
            Self::Straight => "straight",
            Self::PastNose => "past a nose",
            Self::NextNose => "next nose",
            Self::NothingAhead => "nothing ahead",
            Self::Level => "level",
            Self::Landed => "landed",
            Self::Edge => "edge",
            Self::TooHigh => "too high",
            Self::NoProgress => "no progress",
            Self::Timeout => "timeout",
            Self::TooSteep => "too steep",
            Self::Stopped => "stopped",
            Self::Nothing => "nothing there",
            Self::OnTop => "on top",
            Self::Hauled => "hauled",
            Self::Turned => "turned aside",
        }
    }
}

/// What a phase commands.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Order {
    /// Part of the operator's speed; negative is backward.
    pub speed: f32,
    /// Largest speed, m/s.
    pub fastest: f32,
    /// Chassis angle, degrees; `None` stays as it is.
    pub chassis: Option<f32>,
    /// Whether the belts are released; `None` leaves the slack as it is.
    pub released: Option<bool>,
}

/// Condition of a transition. Angles are in degrees, rates in degrees/s.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum When {
    /// The pitch is above this.
    PitchAbove(f32),
    /// The pitch is below this.
    PitchBelow(f32),
    /// The pitch falls faster than this, smoothed.
    FallsFasterThan(f32),
    /// The measured chassis angle is above this.
    ChassisAbove(f32),
    /// The measured chassis angle is within this of straight.
    ChassisWithin(f32),
    /// The pitch has been within [`LEVEL`] of level, and the roll within [`LEVEL_ROLL`], for this
    /// time, s.
    LevelFor(f32),
    /// The heading is more than [`ASIDE`] off the one on level ground before the obstacle.
    Turned,
    /// The pitch has been at rest for this time, s.
    QuietFor(f32),
    /// The belts have travelled this in the phase, in its direction, m.
    Travelled(f32),
    /// The phase has lasted this with a command to move, s. The time of a slow command counts in
    /// part.
    Lasted(f32),
    /// The pitch is above the one at which the robot passes its highest nose.
    TooSteepUp,
    /// The pitch is below that on the noses before by this.
    BelowNoses(f32),
    /// The belts have travelled this since the pitch last changed, m.
    Stuck(f32),
    /// The robot has got over this many noses in a row that were too close to each other: it slides
    /// back in between.
    Slides(u8),
    /// The tracks push as against a wall.
    Pushing,
    /// The obstacle was too high for taut belts, and released ones were not tried yet.
    MayRelease,
}

/// Chassis angle of an arch, degrees.
pub const FOLDED: f32 = -59.0;
/// Largest pitch of a level robot, degrees.
pub const LEVEL: f32 = 4.0;
/// Its largest roll, degrees: the ground behind an obstacle may slope sideways. A robot that lies
/// across stairs rolls more.
pub const LEVEL_ROLL: f32 = 12.0;
/// Angle by which a robot turns aside only if a track fails, degrees. A robot that meets an edge
/// askew turns downhill by less.
pub const ASIDE: f32 = 35.0;

/// One line of the table: in phase `from`, if all of `when` hold, the phase `to` begins.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Transition {
    /// Phase that ends.
    pub from: Phase,
    /// Conditions that end it, all at once.
    pub when: &'static [When],
    /// Cause that is published.
    pub cause: Cause,
    /// Phase that begins.
    pub to: Phase,
}

const fn row(from: Phase, when: &'static [When], cause: Cause, to: Phase) -> Transition {
    Transition {
        from,
        when,
        cause,
        to,
    }
}

impl Phase {
    /// Returns what the phase commands.
    pub fn order(self) -> Order {
        let order = |speed, fastest, chassis| Order {
            speed,
            fastest,
            chassis,
            released: Some(false),
        };
        match self {
            Self::Off | Self::GivenUp | Self::Held => Order {
                released: None,
                ..order(0.0, 0.0, None)
            },
            Self::Approach => order(1.0, 0.25, Some(0.0)),
            Self::Reach => order(1.0, 0.15, Some(45.0)),
            Self::Mount => order(1.0, 0.15, Some(0.0)),
            Self::Climb => order(1.0, 0.15, Some(0.0)),
            Self::Sway => order(1.0, 0.15, Some(-15.0)),
            Self::Crest => order(1.0, 0.15, Some(-15.0)),
            Self::Land => order(1.0, 0.15, Some(0.0)),
            Self::Descend => order(1.0, 0.12, Some(0.0)),
            Self::Withdraw => order(-0.5, 0.08, Some(0.0)),
            Self::Raise => order(1.0, 0.06, Some(45.0)),
            Self::Arch => Order {
                released: Some(true),
                ..order(1.0, 0.06, Some(FOLDED))
            },
            Self::Haul => order(1.0, 0.06, Some(FOLDED)),
        }
    }
}

/// The transitions. In each period the first one counts whose conditions hold.
#[rustfmt::skip]
pub const TABLE: &[Transition] = {
    use Cause as C;
    use Phase as P;
    use When as W;
    &[
        row(P::Approach, &[W::PitchAbove(4.0)], C::FrontLifted, P::Climb),
        row(P::Approach, &[W::PitchBelow(-4.0)], C::Edge, P::Descend),
        row(P::Approach, &[W::Pushing], C::TracksPush, P::Reach),

        row(P::Reach, &[W::Turned], C::Turned, P::Held),
        row(P::Reach, &[W::ChassisAbove(30.0), W::PitchAbove(7.0)], C::NoseUnderFront, P::Mount),
        row(P::Reach, &[W::PitchBelow(-10.0)], C::Edge, P::Descend),
        row(P::Reach, &[W::TooSteepUp], C::TooHigh, P::Withdraw),
        row(P::Reach, &[W::Travelled(0.7), W::LevelFor(0.5)], C::Nothing, P::Approach),
        row(P::Reach, &[W::Travelled(1.2)], C::NoProgress, P::Withdraw),
        row(P::Reach, &[W::Lasted(30.0)], C::Timeout, P::Withdraw),

        row(P::Mount, &[W::Turned], C::Turned, P::Held),
        row(P::Mount, &[W::TooSteepUp], C::TooHigh, P::Withdraw),
        row(P::Mount, &[W::ChassisWithin(3.0)], C::Straight, P::Climb),
        row(P::Mount, &[W::Lasted(10.0)], C::Timeout, P::Withdraw),

        row(P::Climb, &[W::Turned], C::Turned, P::Held),
        row(P::Climb, &[W::TooSteepUp], C::TooHigh, P::Withdraw),
        row(P::Climb, &[W::FallsFasterThan(10.0)], C::PastNose, P::Sway),
        row(P::Climb, &[W::LevelFor(0.2)], C::Level, P::Land),
        row(P::Climb, &[W::PitchBelow(-5.0)], C::Edge, P::Descend),
        row(P::Climb, &[W::Stuck(3.0)], C::NoProgress, P::Withdraw),
        row(P::Climb, &[W::Slides(5)], C::NoProgress, P::Withdraw),
        row(P::Climb, &[W::Lasted(120.0)], C::Timeout, P::Withdraw),

        row(P::Sway, &[W::Turned], C::Turned, P::Held),
        row(P::Sway, &[W::BelowNoses(5.0)], C::NothingAhead, P::Crest),
        row(P::Sway, &[W::PitchBelow(6.0)], C::Level, P::Land),
        row(P::Sway, &[W::QuietFor(0.15)], C::NextNose, P::Climb),
        row(P::Sway, &[W::Lasted(10.0)], C::Timeout, P::Climb),

        row(P::Crest, &[W::Turned], C::Turned, P::Held),
        row(P::Crest, &[W::Lasted(0.5), W::QuietFor(0.2)], C::Level, P::Land),
        row(P::Crest, &[W::Lasted(5.0)], C::Timeout, P::Land),

        row(P::Land, &[W::Turned], C::Turned, P::Held),
        row(P::Land, &[W::Travelled(0.1), W::LevelFor(0.5), W::ChassisWithin(5.0)], C::Landed, P::Approach),
        row(P::Land, &[W::Travelled(0.1), W::QuietFor(0.2), W::PitchAbove(8.0)], C::NextNose, P::Climb),
        row(P::Land, &[W::PitchBelow(-6.0), W::Lasted(0.3)], C::Edge, P::Descend),
        row(P::Land, &[W::Stuck(1.5)], C::NoProgress, P::Withdraw),
        row(P::Land, &[W::Lasted(60.0)], C::Timeout, P::Held),

        row(P::Descend, &[W::Turned], C::Turned, P::Held),
        row(P::Descend, &[W::PitchBelow(-60.0)], C::TooSteep, P::Held),
        row(P::Descend, &[W::Travelled(0.1), W::LevelFor(0.4)], C::Level, P::Land),
        row(P::Descend, &[W::PitchAbove(8.0), W::QuietFor(0.2)], C::NextNose, P::Climb),
        row(P::Descend, &[W::Stuck(4.0)], C::NoProgress, P::Held),
        row(P::Descend, &[W::Lasted(180.0)], C::Timeout, P::Held),

        row(P::Withdraw, &[W::Turned], C::Turned, P::Held),
        row(P::Withdraw, &[W::Travelled(0.1), W::LevelFor(3.0), W::MayRelease], C::Level, P::Raise),
        row(P::Withdraw, &[W::Travelled(0.1), W::LevelFor(3.2)], C::Level, P::GivenUp),
        row(P::Withdraw, &[W::Stuck(2.0)], C::NoProgress, P::Held),
        row(P::Withdraw, &[W::Lasted(120.0)], C::Timeout, P::Held),

        row(P::Raise, &[W::Turned], C::Turned, P::Held),
        row(P::Raise, &[W::ChassisAbove(40.0), W::PitchAbove(8.0)], C::NoseUnderFront, P::Arch),
        row(P::Raise, &[W::PitchBelow(-10.0)], C::Edge, P::Descend),
        row(P::Raise, &[W::Travelled(1.0)], C::NoProgress, P::Withdraw),
        row(P::Raise, &[W::Lasted(40.0)], C::Timeout, P::Withdraw),

        row(P::Arch, &[W::Turned], C::Turned, P::Held),
        row(P::Arch, &[W::PitchAbove(44.0)], C::TooHigh, P::Held),
        row(P::Arch, &[W::Travelled(0.33)], C::OnTop, P::Haul),
        row(P::Arch, &[W::Lasted(30.0)], C::Timeout, P::Held),

        row(P::Haul, &[W::Turned], C::Turned, P::Held),
        row(P::Haul, &[W::PitchAbove(44.0)], C::TooHigh, P::Held),
        row(P::Haul, &[W::Lasted(1.0), W::PitchBelow(11.0)], C::Hauled, P::Land),
        row(P::Haul, &[W::Travelled(1.2)], C::NoProgress, P::Held),
        row(P::Haul, &[W::Lasted(40.0)], C::Timeout, P::Held),
    ]
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_and_causes_survive_their_codes() {
        for phase in Phase::ALL {
            assert_eq!(Phase::from_code(phase as u8), Some(phase));
        }
        for cause in Cause::ALL {
            assert_eq!(Cause::from_code(cause as u8), Some(cause));
        }
        assert_eq!(Phase::from_code(15), None);
        assert_eq!(Cause::from_code(21), None);
    }

    /// A phase in which the robot stands needs no way out. On level ground before an obstacle the
    /// robot may drive for as long as the operator likes.
    #[test]
    fn every_phase_that_moves_the_robot_on_an_obstacle_has_a_timeout_and_leads_to_a_phase_that_ends()
     {
        let at_rest = [Phase::Off, Phase::GivenUp, Phase::Held];
        for phase in Phase::ALL {
            let rows = || TABLE.iter().filter(|row| row.from == phase);
            if at_rest.contains(&phase) {
                assert_eq!(rows().count(), 0, "{phase:?}");
                continue;
            }
            assert!(rows().all(|row| row.to != phase && !row.when.is_empty()));
            let timeout = rows().next_back().expect("a way out");
            assert!(
                phase == Phase::Approach || timeout.cause == Cause::Timeout,
                "{phase:?}"
            );
        }
    }

    #[test]
    fn every_phase_is_reached_and_only_backing_withdraws() {
        let mut reached = [false; Phase::ALL.len()];
        reached[Phase::Approach as usize] = true;
        while let Some(row) = TABLE
            .iter()
            .find(|row| reached[row.from as usize] && !reached[row.to as usize])
        {
            reached[row.to as usize] = true;
        }
        for phase in Phase::ALL {
            assert!(phase == Phase::Off || reached[phase as usize], "{phase:?}");
            let backward = phase.order().speed < 0.0;
            assert_eq!(backward, phase == Phase::Withdraw, "{phase:?}");
        }
    }
}
