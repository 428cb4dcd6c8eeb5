//! Defines the interface of a robot to the guard: a body that knows its stance and turns a command
//! into set-points of its drives.
//!
//! A robot implements [`Body`] once, in its own folder. Network, sequence and filter belong to the
//! guard and are the same for all robots.

use crate::bus::pdo::GuardClearance;
use crate::bus::scale::{Position, Scale, Target};
use crate::estimate::attitude::Attitude;
use crate::estimate::state::Joint;
use crate::settings::{Setting, Settings};
use crate::stability::parameters::Parameters;
use crate::stability::step_behind::StepBehind;
use crate::stability::support::Stance;
use heapless::Vec;

pub use crate::stability::allowed::{Ahead, Allowed, Command, Stop};

/// Maximum number of drives that one guard commands.
pub const MAX_DRIVES: usize = 16;
/// Maximum number of stages between the states "ready" and "armed".
pub const MAX_STAGES: usize = 4;
/// Maximum number of drives with a torque feed-forward.
pub const MAX_OFFSETS: usize = 4;

/// State of a drive as the guard receives it from the bus.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
#[allow(clippy::struct_excessive_bools)] // independent facts, not states
pub struct DriveState {
    /// Position of the output shaft; 0 before the first one is received.
    pub position: Position,
    /// When the position was last received, us since power-up.
    pub received_us: Option<u64>,
    /// Torque at the output shaft, N m.
    pub torque: f32,
    /// Tension of the belts that a screw estimates, N.
    pub belt_tension: f32,
    /// Whether the drive reports that its position is homed.
    pub homed: bool,
    /// Whether the drive is in "operation enabled".
    pub enabled: bool,
    /// Whether the drive is one of [`Body::ODOMETRY`], and turns faster than 0.01 rad/s.
    pub rolls: bool,
    /// Whether the shaft turns without power, and the drive is one of [`Body::ODOMETRY`] or was
    /// under power before.
    pub turns_freely: bool,
}

/// State of drive number `index`; a drive that does not exist is at rest, not homed and off.
#[inline]
pub fn drive_of(drives: &[DriveState], index: usize) -> DriveState {
    drives.get(index).copied().unwrap_or_default()
}

/// Goal that the guard sets for a drive.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Goal {
    /// Switch the bridge off. Only the operator's "disarm" leads to it; no [`Body`] commands it.
    Off,
    /// Ramp down and hold; a drive that is off stays off.
    Hold,
    /// Find the home switch.
    Home,
    /// Follow this position set-point.
    Position(Target),
    /// Move to this position on a profile of the drive's own.
    MoveTo(Target),
    /// Run at this speed, rad/s.
    Velocity(f32),
    /// Keep this slack of the belt, m; 0 and below is taut.
    Belt(f32),
}

/// Torque feed-forward of a drive: the expected load, which the drive applies before any position
/// error arises.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Offset {
    /// Number of the drive.
    pub drive: usize,
    /// Torque at the output shaft, N m; of a screw, the force, N.
    pub load: f32,
}

/// Phase of a robot's operation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Phase {
    /// Starting: the number of the stage, below the length of [`Body::STAGES`].
    Starting(u8),
    /// Armed: the operator drives.
    Armed,
    /// A fault report holds the robot.
    Held,
}

/// What the operator lets the robot's own controller do in a SYNC period.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Autonomy {
    /// The operator commands speed and posture.
    Off,
    /// The controller commands the posture, and how much of the operator's speed it uses.
    On,
    /// As [`Self::On`], but the operator lets the robot stand at present.
    Waits,
    /// As [`Self::On`], but a trip or a fault report has stopped the robot.
    Stopped,
}

/// A robot's commanded posture. On the bus it is a 16-bit word whose meaning depends on the robot.
pub trait PostureCommand: Copy {
    /// Posture of a word on the bus.
    fn from_word(word: i16) -> Self;

    /// The nearest word on the bus.
    fn word(self) -> i16;
}

/// Posture of a robot that has only one. Its word is ignored, and reports show 0.
impl PostureCommand for () {
    fn from_word(_: i16) -> Self {}

    fn word(self) -> i16 {
        0
    }
}

/// Interface of one robot. The guard calls the methods in the order `observe`, `stance`,
/// `stance_ahead`, `advance`, `goal`, once per SYNC.
pub trait Body: Sized {
    /// Reason why settings describe no valid robot.
    type Refusal: core::fmt::Debug;

    /// Posture that the operator commands, in addition to speed and yaw rate.
    type Posture: PostureCommand;

    /// Names of the stages in which the drives start, in order; at most [`MAX_STAGES`]. All but the
    /// last one home drives, which changes the robot's shape.
    const STAGES: &'static [&'static str];

    /// Drives whose encoders [`Body::odometry_um`] uses: the tracks or wheels on which the robot
    /// rolls.
    const ODOMETRY: &'static [usize];

    /// Upper bound of the square of the robot's radius of gyration about a horizontal axis, m^2.
    const GYRATION: f32;

    /// Creates the robot of these settings.
    ///
    /// # Errors
    /// The first setting that is not valid.
    fn new(settings: &Settings) -> Result<Self, Self::Refusal>;

    /// Mass of the robot without payload, kg.
    fn mass(settings: &Settings) -> f32 {
        settings.si(Setting::RobotMass)
    }

    /// Highest step off which the robot may fall backward; by default none.
    fn step_behind(_: &Settings) -> StepBehind {
        StepBehind::NONE
    }

    /// Distance of the driving sides from the middle, m, for a robot that turns by the difference
    /// of their speeds; 0 for a robot that steers.
    fn half_width(_: &Settings) -> f32 {
        0.0
    }

    /// Node ids of the drives, in the order of every `drives` below.
    fn drive_ids(settings: &Settings) -> Vec<u8, MAX_DRIVES>;

    /// Position scale of drive number `drive`, in which [`Body::observe`] and [`Body::goal`] count.
    /// The guard compares it with the drive's own scale at start.
    fn scale(drive: usize) -> Scale;

    /// Takes the latest speed along the level heading from the GNSS receiver, m/s; called before
    /// [`Body::observe`].
    fn receive_speed(&mut self, _along_heading: f32, _: &Attitude) {}

    /// Posture that the operator commands by a word on the bus, and by the flag that releases the
    /// belts. Only a robot whose belts can be released knows the flag.
    fn commanded_posture(&self, word: i16, _belts_released: bool) -> Self::Posture {
        Self::Posture::from_word(word)
    }

    /// Replaces the operator's command by that of the robot's own controller, if it has one and
    /// the operator lets it.
    fn clear(
        &mut self,
        command: Command<Self::Posture>,
        _: Autonomy,
        _: &Attitude,
        _period: f32,
    ) -> Command<Self::Posture> {
        command
    }

    /// Returns the progress of that controller.
    fn clearance(&self) -> GuardClearance {
        GuardClearance::default()
    }

    /// Updates the robot's state from its drives and the attitude filter, `period` s after the
    /// previous call.
    fn observe(&mut self, drives: &[DriveState], attitude: &Attitude, period: f32);

    /// Present stance.
    fn stance(&self, attitude: &Attitude) -> Stance;

    /// Predicted stance `horizon` s from now if the posture moves as `command` commands. `None` if
    /// the posture stays at rest.
    fn stance_ahead(
        &self,
        command: &Command<Self::Posture>,
        attitude: &Attitude,
        horizon: f32,
        period: f32,
    ) -> Option<Ahead>;

    /// Scale of a forward speed, 0 to 1, with which the robot does not turn over if it drives over
    /// an edge that it does not see. NaN passes nothing.
    fn forward_scale(&self, _: &Attitude) -> f32 {
        1.0
    }

    /// Stance in this attitude with the shape of the previous observation.
    ///
    /// The margins that the present stance loses against it are lost by the change of shape, which
    /// is no decay ([`crate::stability::tracker`]). `None` if the shape is how the robot follows
    /// the ground, so that every loss counts as decay.
    fn stance_with_kept_shape(&self, _: &Attitude) -> Option<Stance> {
        None
    }

    /// Stance number `index` of those that homing takes the robot through, on the plane that it
    /// stands on now. `None` behind the last one, and if homing leaves the shape as it is.
    fn homing_stance(&self, _index: usize, _: &Attitude) -> Option<Stance> {
        None
    }

    /// Stops all motion: sets every set-point to the measured position.
    fn rest(&mut self);

    /// Acknowledges, on the operator's request, the way in which a motion such as a gait ended.
    fn acknowledge(&mut self) {}

    /// Moves the set-points toward `command`, as far as `allowed` and within the robot's own
    /// limits.
    fn advance(
        &mut self,
        command: &Command<Self::Posture>,
        allowed: Allowed,
        attitude: &Attitude,
        period: f32,
    );

    /// Stage with which the robot starts.
    fn first_stage(&self, drives: &[DriveState]) -> u8;

    /// Whether `stage` is complete.
    fn reached(&mut self, stage: u8, drives: &[DriveState], now_us: u64) -> bool;

    /// Goal of drive number `drive`.
    fn goal(&self, phase: Phase, drive: usize) -> Goal;

    /// Torque feed-forward for the present set-points; a drive that is not listed has none.
    fn offsets(&self, _: Phase, _: &Attitude) -> Vec<Offset, MAX_OFFSETS> {
        Vec::new()
    }

    /// Forward speed of the present set-points, m/s.
    fn speed(&self) -> f32;

    /// Time in which the robot comes to rest from that speed, s.
    fn stopping_time(&self) -> f32;

    /// Posture of the present set-points.
    fn posture(&self) -> Self::Posture;

    /// Slack of the belts, m, of a robot that has a screw: that of the present set-points, and the
    /// measured one, negative where a belt is strained.
    fn slack(&self) -> [f32; 2] {
        [0.0; 2]
    }

    /// Tension of the belts that the screw estimates, N.
    fn belt_tension(&self) -> f32 {
        0.0
    }

    /// Distance that the robot has travelled by its encoders, forward positive, um; wraps.
    fn odometry_um(&self) -> i32;

    /// Joints q7 and q8 of Paillat et al., for a robot that has them.
    fn joints(&self, _: &[DriveState]) -> [Joint; 2] {
        [Joint::default(); 2]
    }
}

/// Parameters of the balance of a robot with these settings.
pub fn balance_parameters<B: Body>(settings: &Settings) -> Parameters {
    let mut parameters = Parameters::new(settings);
    parameters.uncertainty.robot_mass = B::mass(settings);
    parameters.gyration = B::GYRATION;
    parameters.step_behind = B::step_behind(settings);
    parameters.half_width = B::half_width(settings);
    parameters
}
