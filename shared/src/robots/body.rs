//! What a robot is to the guard: a body that knows how it stands and turns a command into set-points of its drives.
//!
//! A robot implements [`Body`] once, in its own folder. Network, sequence and filter are the guard's and the same for all.

use crate::bus::scale::{Position, Scale, Target};
use crate::estimate::state::Joint;
use crate::math::{limit, min, to_i16};
use crate::motor::profile::{self, Motion};
use crate::settings::{Setting, Settings};
use crate::stability::attitude::Attitude;
use crate::stability::limits::MotionLimits;
use crate::stability::step_behind::StepBehind;
use crate::stability::support::Stance;
use heapless::Vec;

/// Most drives that one guard commands.
pub const MAX_DRIVES: usize = 16;
/// Most stages between "ready" and "armed".
pub const MAX_STAGES: usize = 4;
/// Most drives that are told a torque in advance.
pub const MAX_OFFSETS: usize = 4;

/// A drive as the guard knows it from the bus.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct DriveState {
    /// Position of the output shaft; 0 before the first was received.
    pub position: Position,
    /// When the position was last received, us since power-up.
    pub received_us: Option<u64>,
    /// Torque at the output shaft, N m.
    pub torque: f32,
    /// The drive says that its position is homed.
    pub homed: bool,
    /// The drive is in "operation enabled".
    pub enabled: bool,
}

/// The state of drive number `index`; one that is not there is at rest, unhomed and off.
#[inline]
pub fn drive_of(drives: &[DriveState], index: usize) -> DriveState {
    drives.get(index).copied().unwrap_or_default()
}

/// What a drive shall do.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Goal {
    /// Bridge off.
    Off,
    /// Ramp down and hold.
    Hold,
    /// Find the home switch.
    Home,
    /// Follow this position.
    Position(Target),
    /// Move to this position by itself.
    MoveTo(Target),
    /// Run at this speed, rad/s.
    Velocity(f32),
    /// Keep the belt taut.
    Taut,
}

/// A torque that a drive shall have in advance of any error.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Offset {
    /// Number of the drive.
    pub drive: usize,
    /// Torque at the output shaft, 0.01 N m; screw: force, N.
    pub torque: i16,
}

/// What the robot is about to do, or does.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Phase {
    /// Coming to life: the number of the stage, below the length of [`Body::STAGES`].
    Starting(u8),
    /// The operator drives.
    Armed,
    /// A fault or a loss holds the robot.
    Held,
}

/// A robot's commanded posture. On the bus it is a 16-bit word, whose meaning depends on the robot.
pub trait PostureCommand: Copy {
    /// Posture of a word on the bus.
    fn from_word(word: i16) -> Self;

    /// The nearest word.
    fn word(self) -> i16;
}

/// The posture of a robot that has only one. Its word is not read, and reports show 0.
impl PostureCommand for () {
    fn from_word(_: i16) -> Self {}

    fn word(self) -> i16 {
        0
    }
}

/// The word of a height in m that counts millimetres: the nearest one.
pub fn millimetres(metres: f32) -> i16 {
    let word = metres * 1e3;
    to_i16(word + f32::copysign(0.5, word))
}

/// Motion that the operator asks for, of a robot with postures `P`.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Asked<P> {
    /// Forward speed over ground, m/s.
    pub forward: f32,
    /// Yaw rate, counter-clockwise from above, rad/s.
    pub yaw_rate: f32,
    /// Commanded posture.
    pub posture: P,
}

/// Why nothing may move, and how hard the robot brakes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Stop {
    /// The operator stops, is absent, or the sensors are not trusted: brakes comfortably.
    Gentle,
    /// The guard has tripped: brakes as hard as the limits bear.
    Hard,
}

/// What the filter leaves of it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Allowed {
    /// Share of the asked speeds, 0 to 1.
    pub speed_scale: f32,
    /// The robot is to stand still: wheels, legs, arms and levelling brake to rest.
    pub stop: Option<Stop>,
    /// Whether the posture may move on.
    pub posture: bool,
    /// Within which limits both.
    pub limits: MotionLimits,
}

impl Allowed {
    /// Moves the speed of `motion` toward `asked` (m/s) times the speed scale, within the robot's `own` limits and the accelerations that
    /// are handed down. The guard's own stops know only the latter.
    pub fn ramp(&self, motion: &mut Motion, asked: f32, own: profile::Limits, period: f32) {
        let target = limit(asked, own.velocity) * self.speed_scale;
        let handed_down = if target > motion.velocity {
            self.limits.forward
        } else {
            self.limits.backward
        };
        let slows = target.abs() < motion.velocity.abs();
        let acceleration = if slows && (self.stop == Some(Stop::Hard) || self.speed_scale < 1.0) {
            handed_down
        } else {
            min(handed_down, own.acceleration)
        };
        let limits = profile::Limits {
            acceleration,
            ..own
        };
        motion.toward_velocity(target, limits, period);
    }

    /// Yaw rate, rad/s, with which a robot at `speed` (m/s) is on the curve that was asked for while it still speeds up; on the spot, the
    /// the speed scale of what was asked. Never more than asked.
    pub fn yaw_rate_on_the_curve<P>(&self, asked: &Asked<P>, speed: f32) -> f32 {
        if asked.forward == 0.0 {
            asked.yaw_rate * self.speed_scale
        } else {
            limit(
                asked.yaw_rate * (speed / asked.forward),
                asked.yaw_rate.abs(),
            )
        }
    }
}

/// Where a posture's motion leads.
#[derive(Clone, Copy, Debug)]
pub struct Ahead {
    /// How the robot will stand.
    pub stance: Stance,
    /// The motion folds down a front that the robot stands on. This lifts the body.
    pub lifts: bool,
}

impl From<Stance> for Ahead {
    fn from(stance: Stance) -> Self {
        Self {
            stance,
            lifts: false,
        }
    }
}

/// One robot. The methods are called in the order `observe`, `stance`, `stance_ahead`, `advance`, `goal`, once per SYNC.
pub trait Body: Sized {
    /// Why settings make no such robot.
    type Refusal: core::fmt::Debug;

    /// What the operator commands beside speed and yaw rate.
    type Posture: PostureCommand;

    /// Names of the stages in which its drives come to life, in order; at most [`MAX_STAGES`].
    const STAGES: &'static [&'static str];

    /// The drives whose encoders [`Body::odometry_um`] comes from.
    const ODOMETRY: &'static [usize];

    /// The robot of these settings.
    ///
    /// # Errors
    /// The first setting that makes none.
    fn new(settings: &Settings) -> Result<Self, Self::Refusal>;

    /// Mass of the robot without payload, kg.
    fn mass(settings: &Settings) -> f32 {
        settings.scaled(Setting::RobotMass, 1e-3)
    }

    /// Highest step off which it may fall backward; by default none.
    fn step_behind(_: &Settings) -> StepBehind {
        StepBehind::NONE
    }

    /// Distance of its driving sides from its middle, m, if it turns by their different speeds; 0 of a
    /// robot that steers.
    fn half_width(_: &Settings) -> f32 {
        0.0
    }

    /// Node ids of its drives, in the order in which every `drives` below has them.
    fn drive_ids(settings: &Settings) -> Vec<u8, MAX_DRIVES>;

    /// Position scale of drive number `drive`: the one in which [`Body::observe`] and [`Body::goal`]
    /// count. The guard compares it with the drive's own at start.
    fn scale(drive: usize) -> Scale;

    /// Takes the speed along its level heading that the GNSS receiver measured lately, m/s, before [`Body::observe`].
    fn receive_speed(&mut self, _along_heading: f32, _: &Attitude) {}

    /// Takes what the drives and the attitude filter say, `period` s after the call before.
    fn observe(&mut self, drives: &[DriveState], attitude: &Attitude, period: f32);

    /// How it stands now.
    fn stance(&self, attitude: &Attitude) -> Stance;

    /// Where its posture will be `horizon` s from now if it goes where `asked` has it. None if its
    /// posture stays at rest.
    fn stance_ahead(
        &self,
        asked: &Asked<Self::Posture>,
        attitude: &Attitude,
        horizon: f32,
        period: f32,
    ) -> Option<Ahead>;

    /// How the robot would stand in this attitude with its shape of the observation before. What the
    /// margins lose against it is the change of shape, and no decay ([`crate::stability::tracker`]).
    /// None where the shape is how the robot follows the ground, so that every loss counts.
    fn stance_with_kept_shape(&self, _: &Attitude) -> Option<Stance> {
        None
    }

    /// Gives up every motion: set-points are where the robot is.
    fn rest(&mut self);

    /// The operator acknowledges whatever the robot came to an end with.
    fn acknowledge(&mut self) {}

    /// Moves its set-points toward `asked` as far as `allowed`, within its own limits.
    fn advance(
        &mut self,
        asked: &Asked<Self::Posture>,
        allowed: Allowed,
        attitude: &Attitude,
        period: f32,
    );

    /// The stage with which coming to life begins.
    fn first_stage(&self, drives: &[DriveState]) -> u8;

    /// Whether `stage` has come to its end.
    fn reached(&mut self, stage: u8, drives: &[DriveState], now_us: u64) -> bool;

    /// What drive number `drive` shall do.
    fn goal(&self, phase: Phase, drive: usize) -> Goal;

    /// What the body knows in advance of the torques that its set-points take; a drive that is not named has none.
    fn offsets(&self, _: Phase, _: &Attitude) -> Vec<Offset, MAX_OFFSETS> {
        Vec::new()
    }

    /// Forward speed that its set-points have now, m/s.
    fn speed(&self) -> f32;

    /// Time in which it comes to rest from that speed, s.
    fn stopping_time(&self) -> f32;

    /// Posture that its set-points have now.
    fn posture(&self) -> Self::Posture;

    /// Distance that it went by its encoders, forward positive, um; wraps.
    fn odometry_um(&self) -> i32;

    /// The paper's q7 and q8, of a robot that has them.
    fn joints(&self, _: &[DriveState]) -> [Joint; 2] {
        [Joint::default(); 2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From 0.4 m/s, with 1.5 m/s^2 handed down and 0.4 m/s^2 of its own, for a tenth of a second.
    fn slowed(asked: f32, speed_scale: f32, stop: Option<Stop>) -> f32 {
        let allowed = Allowed {
            speed_scale,
            stop,
            posture: true,
            limits: MotionLimits {
                forward: 1.5,
                backward: 1.5,
                ..MotionLimits::default()
            },
        };
        let own = profile::Limits {
            velocity: 0.5,
            acceleration: 0.4,
        };
        let mut motion = Motion {
            velocity: 0.4,
            ..Motion::default()
        };
        for _ in 0..25 {
            allowed.ramp(&mut motion, asked, own, 4e-3);
        }
        motion.velocity
    }

    #[test]
    fn the_guard_stops_as_hard_as_the_limits_bear_and_the_operator_gently() {
        for (asked, speed_scale, stop, rate) in [
            (0.4, 0.0, None, -1.5),
            (0.0, 1.0, Some(Stop::Hard), -1.5),
            (0.0, 1.0, Some(Stop::Gentle), -0.4),
            (0.0, 1.0, None, -0.4),
            (0.5, 1.0, None, 0.4),
            // Taken less of, it still speeds up gently.
            (0.5, 0.9, None, 0.4),
        ] {
            let expected = 0.4 + 0.1 * rate;
            let found = slowed(asked, speed_scale, stop);
            assert!(
                (found - expected).abs() < 2e-3,
                "{asked} {speed_scale} {stop:?}: {found}"
            );
        }
    }
}
