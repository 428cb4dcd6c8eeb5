//! Implements [`Body`] for B2P2: its stance, and the set-points of its drives for a command.

use super::clearance::phases::FOLDED;
use super::clearance::{Clearance, Facts, Straight, may_arch};
use super::shape::AXLE_3_FROM_BODY_3;
use super::{FrontPart, Masses, Model};
use crate::bus::pdo::GuardClearance;
use crate::bus::scale::{Position, Scale, Target};
use crate::constants::GRAVITY;
use crate::estimate::attitude::Attitude;
use crate::estimate::state::Joint;
use crate::math::{Turns, atan2, clamp, limit, max, min, sin_cos, to_i32};
use crate::motor::profile::{Limits, Motion};
use crate::robots::body::{
    Ahead, Allowed, Autonomy, Body, Command, DriveState, Goal, MAX_DRIVES, MAX_OFFSETS, Offset,
    Phase, PostureCommand, drive_of,
};
use crate::robots::odometry::Odometry;
use crate::robots::turn::Turn;
use crate::screw::{self, Extension, Geometry, GeometryError, SlackLaw, metres};
use crate::settings::{Setting, Settings};
use crate::stability::step_behind::StepBehind;
use crate::stability::support::Stance;
use crate::units::{Angle, Length};
use heapless::Vec;

/// Gain with which the heading is held while no yaw is commanded, 1/s, and the largest yaw rate for
/// this, rad/s.
const HEADING_GAIN: f32 = 1.5;
const HEADING_RATE: f32 = 0.3;
/// Acceleration of the chassis joint, rad/s^2.
const CHASSIS_ACCELERATION: f32 = 4.0;
/// While the robot may fall forward over an edge, the angle by which it would turn in all until it
/// lies on its front, rad: the angle up to which the whole forward speed passes (80 degrees), and
/// the one from which none does (90 degrees: it turns over).
const FALLS_WELL: f32 = 1.396;
const TURNS_OVER: f32 = 1.571;
/// Edge off which no robot turns over, m.
const LOW: f32 = 0.05;
/// Pitch below which a robot counts as driving on level ground, rad. So an error of the pitch adds
/// up to no climb.
const LEVEL: f32 = 0.05;

/// Largest distance from a target at which it counts as reached: joint 2^-32 turn (0.5 degree),
/// screw m.
const JOINT_THERE: u32 = 5_965_232;
const SCREW_THERE: f32 = 0.5e-3;
/// Time for which the belt must be taut before the robot is armed, us.
const TAUT_DWELL_US: u64 = 100_000;

/// While the belts are tightened: how far the slack's set-point is ahead of the measured slack,
/// and the set-point until they are taut, m; the measured slack below which they count as taut, m,
/// and for how long, s.
const TIGHTEN_LEAD: f32 = 2e-3;
const ALMOST_TAUT: f32 = 0.1e-3;
const TAUT: f32 = 1e-3;
const TAUT_DWELL: f32 = 0.1;

/// Number of each drive among the robot's drives.
const LEFT: usize = 0;
const RIGHT: usize = 1;
const JOINT: usize = 2;
const SCREW: usize = 3;

/// Chassis angles that homing may reach, 2^-32 turn (100 degrees either way: a home switch that is
/// stuck does not end the motion), and the number of angles at which the stance is predicted.
const HOMING_TRAVEL: [i64; 2] = [-1_193_046_471, 1_193_046_471];
const PREDICTED: usize = 9;

/// Stages of [`Body::STAGES`]. Their order keeps the belt from tearing: the screw first retracts to
/// where the belt is slack at any chassis angle, only then is the joint homed, and the screw
/// tightens the belt last.
const HOME_SCREW: u8 = 0;
const HOME_JOINT: u8 = 1;
const STRAIGHTEN: u8 = 2;
const TIGHTEN: u8 = 3;

/// The tracked robot B2P2 under the guard.
#[derive(Clone, Debug)]
pub struct B2p2 {
    model: Model,
    front: FrontPart,
    geometry: Geometry,
    slack_law: SlackLaw,
    speed: Limits,
    chassis_limits: Limits,
    gauge: f32,
    pulley_radius: f32,
    /// Extension of the screw at which the belt is slack at any chassis angle, m.
    released: Length,

    joint_known: bool,
    screw_known: bool,
    theta: Angle,
    extension: f32,
    /// Chassis angle and extension at the previous observation.
    kept_shape: (Angle, f32),
    tracks: Option<[Position; 2]>,
    odometry: Odometry,
    /// Height above the lowest place where the robot has been since power-up, m; and the largest
    /// height of an edge that it may have climbed unseen.
    climbed: f32,
    step: f32,
    taut_since_us: Option<u64>,
    /// Whether the screw keeps the slack of the belts, because the robot was armed.
    keeps_slack: bool,
    /// Set-point of the chassis joint, 2^-32 turn.
    chassis: Motion,
    /// Set-point of the slack, m, and its largest rate, m/s; the slack that the operator's flag
    /// commands, m; and the measured slack, m.
    slack: f32,
    slack_rate: f32,
    release_slack: f32,
    measured_slack: f32,
    /// Time for which belts that are tightened have been taut, s, and their tension, N.
    taut_for: f32,
    belt_tension: f32,
    /// Forward speed that is passed on; the position of this motion is not used.
    forward: Motion,
    turn: Turn,
    heading: Option<Angle>,
    clearance: Clearance,
    /// Weight with the declared payload, N.
    weight: f32,
    /// Torque of both tracks, N m; odometry at the previous call of [`Body::clear`], um.
    track_torque: f32,
    cleared_um: Option<i32>,
    /// Angle by which a lowered front lifts the body off its belts' lower run, rad, at that call.
    lifted: Option<f32>,
}

/// Commanded shape of the front. On the bus its word is the angle, in 2^-16 turn; the slack comes
/// from a flag.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Front {
    /// Angle of the chassis joint.
    pub angle: Angle,
    /// Slack of the belts, m; 0 is taut.
    pub slack: f32,
}

impl PostureCommand for Front {
    /// With taut belts.
    fn from_word(word: i16) -> Self {
        Self {
            angle: Angle::from_bits(i32::from(word) << 16),
            slack: 0.0,
        }
    }

    fn word(self) -> i16 {
        (self.angle.to_bits().wrapping_add(0x8000) >> 16) as i16
    }
}

impl B2p2 {
    fn stance_at(&self, theta: Angle, extension: f32, attitude: &Attitude) -> Stance {
        let shape = self.model.shape(theta, extension);
        self.model.stance(&shape, &attitude.level_axes())
    }

    fn next_chassis(&self, asked: Front, speed_scale: f32, period: f32) -> Motion {
        // The joint turns less than half a turn each way, so the wrapped angle is the angle.
        let target = Turns::from(asked.angle);
        let mut next = self.chassis;
        let limits = Limits {
            velocity: self.chassis_limits.velocity * speed_scale,
            ..self.chassis_limits
        };
        next.toward_position(target, limits, period);
        next
    }

    /// Slack after the time `period`, s, on the way to the commanded one; NaN does not move it.
    ///
    /// The screw tightens the belts with a limited tension, at its own pace. So the set-point goes
    /// only a little ahead of the measured slack, and a stop keeps the slack that there is.
    fn next_slack(&self, asked: Front, speed_scale: f32, period: f32) -> f32 {
        let tightens = asked.slack < self.slack && self.taut_for < TAUT_DWELL;
        let target = if tightens {
            let ahead = max(self.measured_slack - TIGHTEN_LEAD, ALMOST_TAUT);
            max(ahead, asked.slack)
        } else {
            asked.slack
        };
        let change = limit(target - self.slack, self.slack_rate * speed_scale * period);
        max(self.slack + change, 0.0)
    }

    /// Extension by the law of the belts at this chassis angle and slack. The screw does not draw
    /// back below the released length.
    fn extension_at(&self, theta: Angle, slack: f32) -> Extension {
        let taut = self.geometry.extension(theta);
        let extension = self.slack_law.extension(taut, slack);
        let length = self.geometry.released_length();
        // The taut length at angle 0 may be rounded below the released one.
        if slack > 0.0 && extension.length < length {
            let derivative = Length::ZERO;
            return Extension { length, derivative };
        }
        extension
    }

    /// Commanded yaw rate, or the one that holds the heading while none is commanded.
    fn yaw(&mut self, asked: f32, attitude: &Attitude) -> f32 {
        if asked != 0.0 || self.forward.velocity == 0.0 {
            self.heading = None;
            return asked;
        }
        let wanted = *self.heading.get_or_insert(attitude.heading());
        // Neither side turns against the direction of travel.
        let most = min(
            HEADING_RATE,
            self.forward.velocity.abs() / (0.5 * self.gauge),
        );
        limit(HEADING_GAIN * (wanted - attitude.heading()).radians(), most)
    }

    /// Set-point of a track whose centre line is `left` m to the left of the middle, rad/s.
    fn track_speed(&self, left: f32) -> f32 {
        (self.forward.velocity - left * self.turn.rate()) / self.pulley_radius
    }

    /// Extension that holds the belt taut at the measured chassis angle, m.
    fn taut(&self) -> f32 {
        metres(self.geometry.length(self.theta))
    }

    /// Whether all drives are enabled and the screw has held the belt taut for [`TAUT_DWELL_US`].
    fn tight(&mut self, drives: &[DriveState], now_us: u64) -> bool {
        let enabled = drives.iter().all(|drive| drive.enabled);
        let away = drive_of(drives, SCREW).position.metres() - self.taut();
        if !enabled || away.abs() >= SCREW_THERE {
            self.taut_since_us = None;
            return false;
        }
        let since = *self.taut_since_us.get_or_insert(now_us);
        now_us.saturating_sub(since) >= TAUT_DWELL_US
    }
}

impl Body for B2p2 {
    type Refusal = GeometryError;
    type Posture = Front;

    const STAGES: &'static [&'static str] = &[
        "homing screw",
        "homing joint",
        "straightening",
        "tightening",
    ];
    const ODOMETRY: &'static [usize] = &[LEFT, RIGHT];
    // Straight and without payload, from the paper's inertias. With the front folded or a payload
    // it is 0.04 m^2.
    const GYRATION: f32 = 0.053;

    fn new(settings: &Settings) -> Result<Self, GeometryError> {
        let geometry = Geometry::from_micrometres(
            settings.get(Setting::LengthL1),
            settings.get(Setting::LengthL2),
            settings.get(Setting::LengthK),
        )?;
        // In whole units of the bus, 2^-24 m.
        let retreat = (i64::from(settings.get(Setting::HomingRetreat)) << 24) / 1_000_000;
        let released = (geometry.released_length().to_bits() >> 4) - retreat as i32;
        let released = Length::from_bits(released << 4);
        let model = Model::new(settings);
        let straight = model.shape(Angle::ZERO, metres(geometry.extension(Angle::ZERO).length));
        let angle = Angle::from_degrees(FOLDED);
        let folded = model.shape(angle, metres(geometry.extension(angle).length));
        let masses = Masses::new(settings);
        Ok(Self {
            clearance: Clearance::new(
                &Straight {
                    cog: [straight.cog[0], straight.cog[2]],
                    length: straight.axle_3[0],
                    pulley_radius: settings.si(Setting::PulleyRadius),
                },
                may_arch([folded.cog[0], folded.cog[2]]),
            ),
            weight: (masses.of_robot() + masses.payload.mass) * GRAVITY,
            track_torque: 0.0,
            cleared_um: None,
            lifted: None,
            model,
            front: FrontPart::new(&geometry, settings),
            slack_law: SlackLaw::new(&geometry),
            geometry,
            speed: Limits {
                velocity: settings.si(Setting::SpeedLimit),
                acceleration: settings.si(Setting::DriveAcceleration),
            },
            chassis_limits: Limits {
                velocity: settings.si(Setting::ChassisSpeed),
                acceleration: CHASSIS_ACCELERATION,
            },
            gauge: settings.si(Setting::TrackGauge),
            pulley_radius: settings.si(Setting::PulleyRadius),
            released,
            joint_known: false,
            screw_known: false,
            theta: Angle::ZERO,
            kept_shape: (Angle::ZERO, 0.0),
            extension: screw::metres(released),
            tracks: None,
            odometry: Odometry::default(),
            climbed: 0.0,
            step: settings.si(Setting::StepBehind),
            taut_since_us: None,
            keeps_slack: false,
            chassis: Motion::default(),
            slack: 0.0,
            slack_rate: settings.si(Setting::EngageSpeed),
            release_slack: settings.si(Setting::ReleaseSlack),
            measured_slack: 0.0,
            taut_for: 0.0,
            belt_tension: 0.0,
            forward: Motion::default(),
            turn: Turn::new(Self::half_width(settings), settings),
            heading: None,
        })
    }

    fn mass(settings: &Settings) -> f32 {
        Masses::new(settings).of_robot()
    }

    fn step_behind(settings: &Settings) -> StepBehind {
        StepBehind {
            height: settings.si(Setting::StepBehind),
            gyration: Self::GYRATION,
        }
    }

    fn half_width(settings: &Settings) -> f32 {
        0.5 * settings.si(Setting::TrackGauge)
    }

    fn drive_ids(settings: &Settings) -> Vec<u8, MAX_DRIVES> {
        [
            Setting::LeftId,
            Setting::RightId,
            Setting::JointId,
            Setting::ScrewId,
        ]
        .into_iter()
        .map(|setting| settings.id(setting))
        .collect()
    }

    fn scale(drive: usize) -> Scale {
        match drive {
            JOINT => Scale::Turning { bits: 32 },
            SCREW => Scale::linear(1),
            _ => Scale::Turning { bits: 16 },
        }
    }

    fn commanded_posture(&self, word: i16, belts_released: bool) -> Front {
        Front {
            slack: if belts_released {
                self.release_slack
            } else {
                0.0
            },
            ..Front::from_word(word)
        }
    }

    fn clear(
        &mut self,
        command: Command<Front>,
        autonomy: Autonomy,
        attitude: &Attitude,
        period: f32,
    ) -> Command<Front> {
        let odometry_um = self.odometry.um();
        let before = self.cleared_um.replace(odometry_um).unwrap_or(odometry_um);
        if autonomy != Autonomy::On {
            self.lifted = None;
            match autonomy {
                Autonomy::Off => self.clearance.end(),
                // The operator's chassis angle counts again when he takes over.
                Autonomy::Stopped => {
                    self.clearance.stop();
                    return Command {
                        posture: self.posture(),
                        ..command
                    };
                }
                Autonomy::On | Autonomy::Waits => {}
            }
            return command;
        }
        let [x, _, z] = self.model.shape(self.theta, self.extension).axle_3;
        let lifted = atan2(-min(z, 0.0), x);
        let lifts = (lifted - self.lifted.replace(lifted).unwrap_or(lifted)) / period;
        let wanted = self.clearance.advance(&Facts {
            pitch: attitude.pitch().radians() - lifted,
            pitch_rate: attitude.pitch_rate() - lifts,
            chassis: self.theta.radians(),
            travel: odometry_um.wrapping_sub(before) as f32 * 1e-6,
            push: self.track_torque / (self.pulley_radius * self.weight),
            roll: attitude.roll().radians(),
            heading: attitude.heading(),
            speed: command.forward,
            yaw_rate: command.yaw_rate,
            period,
        });
        Command {
            forward: wanted.speed,
            yaw_rate: wanted.yaw_rate,
            posture: Front {
                angle: wanted
                    .chassis
                    .map_or(self.chassis.position.angle(), Angle::from_radians),
                slack: match wanted.released {
                    Some(true) => self.release_slack,
                    Some(false) => 0.0,
                    None => self.slack,
                },
            },
        }
    }

    fn clearance(&self) -> GuardClearance {
        self.clearance.report()
    }

    fn observe(&mut self, drives: &[DriveState], attitude: &Attitude, _: f32) {
        self.kept_shape = (self.theta, self.extension);
        self.joint_known = drive_of(drives, JOINT).homed;
        self.screw_known = drive_of(drives, SCREW).homed;
        if self.joint_known {
            self.theta = drive_of(drives, JOINT).position.angle();
        }
        if self.screw_known {
            self.extension = drive_of(drives, SCREW).position.metres();
        }
        if self.joint_known && self.screw_known {
            let length = Length::from_bits(to_i32(self.extension * 268_435_456.0));
            self.measured_slack = metres(self.geometry.slack(self.theta, length));
        }
        self.track_torque = drive_of(drives, LEFT).torque + drive_of(drives, RIGHT).torque;
        self.belt_tension = drive_of(drives, SCREW).belt_tension;
        let tracks = [LEFT, RIGHT].map(|side| drive_of(drives, side).position);
        if let Some(before) = self.tracks {
            let turns = |side: usize| tracks[side].turns_since(before[side]);
            let way = core::f32::consts::PI * self.pulley_radius * (turns(0) + turns(1));
            self.odometry.add(way * 1e6);
            let pitch = attitude.pitch();
            if pitch.radians().abs() > LEVEL {
                self.climbed = max(self.climbed + way * sin_cos(pitch).0, 0.0);
            }
        }
        self.tracks = Some(tracks);
    }

    fn stance(&self, attitude: &Attitude) -> Stance {
        self.stance_at(self.theta, self.extension, attitude)
    }

    fn stance_with_kept_shape(&self, attitude: &Attitude) -> Option<Stance> {
        let (theta, extension) = self.kept_shape;
        Some(self.stance_at(theta, extension, attitude))
    }

    fn stance_ahead(
        &self,
        asked: &Command<Front>,
        attitude: &Attitude,
        horizon: f32,
        period: f32,
    ) -> Option<Ahead> {
        let next = self.next_chassis(asked.posture, 1.0, period);
        let slack = self.next_slack(asked.posture, 1.0, period + horizon);
        let slackens = slack != self.slack;
        let moves = next.position != self.chassis.position || slackens;
        if !moves && next.velocity == 0.0 && self.chassis.velocity == 0.0 {
            return None;
        }
        // From the set-point, not from the measured angle, because the joint will still reach what
        // already passed.
        let ahead = next.position.angle() + Angle::from_radians(next.velocity * horizon);
        let extension = metres(self.extension_at(ahead, slack).length);
        let shape = self.model.shape(ahead, extension);
        let lowered = next.position < Turns::ZERO;
        let lifts = next.position < self.chassis.position && lowered;
        let axes = attitude.level_axes();
        // A lowered front carries the robot, so the body also turns when the screw moves axle 3.
        let axes = if lifts || slackens && lowered {
            let present = self.model.shape(self.theta, self.extension);
            axes.pitched(present.lift(&shape))
        } else {
            axes
        };
        Some(Ahead {
            stance: self.model.stance(&shape, &axes),
            lifts,
        })
    }

    /// A robot that has climbed may drive over an edge. It then turns about the edge until its body
    /// reaches the ground below, and falls on about axle 2 onto its raised front. Its body turns
    /// over if all this is more than a right angle.
    fn forward_scale(&self, attitude: &Attitude) -> f32 {
        let height = min(self.climbed, self.step);
        if !(height > LOW) {
            return 1.0;
        }
        let sine = height / self.model.l1();
        // Arc sine, with an error below 1 % up to 0.6 rad.
        let edge = sine * (1.0 + sine * sine / 6.0);
        let turned = self.theta.radians() + edge - attitude.pitch().radians();
        clamp((TURNS_OVER - turned) / (TURNS_OVER - FALLS_WELL), 0.0, 1.0)
    }

    /// A joint that is not homed may be anywhere, so homing may take it through its whole travel.
    fn homing_stance(&self, index: usize, attitude: &Attitude) -> Option<Stance> {
        if index >= PREDICTED {
            return None;
        }
        let [low, high] = if self.joint_known {
            [0, i64::from(self.theta.to_bits())]
        } else {
            HOMING_TRAVEL
        };
        let theta = low + (high - low) * index as i64 / (PREDICTED as i64 - 1);
        let shape = |theta| self.model.shape(theta, self.extension);
        let predicted = shape(Angle::from_bits(theta as i32));
        let lift = shape(self.theta).lift(&predicted);
        let axes = attitude.level_axes().pitched(lift);
        Some(self.model.stance(&predicted, &axes))
    }

    fn rest(&mut self) {
        self.forward = Motion::default();
        self.turn.rest();
        self.heading = None;
        self.chassis = Motion::at(self.theta.into());
    }

    fn advance(
        &mut self,
        asked: &Command<Front>,
        allowed: Allowed,
        attitude: &Attitude,
        period: f32,
    ) {
        self.keeps_slack = true;
        // The speed scale applies to what the belts can do, not to a larger command.
        let bounded = self.turn.within(*asked);
        let yaw_rate = self.yaw(bounded.yaw_rate * allowed.speed_scale, attitude);
        let driven = self.turn.within(Command {
            yaw_rate,
            ..bounded
        });
        allowed.ramp(&mut self.forward, driven.forward, self.speed, period);
        let speed = self.forward.velocity;
        self.turn.advance(driven.yaw_rate, speed, &allowed, period);
        let taut = self.measured_slack < TAUT && self.slack <= ALMOST_TAUT;
        self.taut_for = if taut { self.taut_for + period } else { 0.0 };
        if allowed.posture {
            let scale = allowed.limits.posture;
            self.slack = self.next_slack(asked.posture, scale, period);
            self.chassis = self.next_chassis(asked.posture, scale, period);
        } else {
            self.chassis
                .toward_velocity(0.0, self.chassis_limits, period);
        }
    }

    fn first_stage(&self, drives: &[DriveState]) -> u8 {
        if drives.iter().all(|drive| drive.homed) {
            TIGHTEN
        } else {
            HOME_SCREW
        }
    }

    fn reached(&mut self, stage: u8, drives: &[DriveState], now_us: u64) -> bool {
        (self.keeps_slack, self.slack) = (false, 0.0);
        if stage != TIGHTEN {
            self.taut_since_us = None;
        }
        let (joint, screw) = (drive_of(drives, JOINT), drive_of(drives, SCREW));
        match stage {
            HOME_SCREW => {
                let away = screw.position.metres() - metres(self.released);
                screw.homed && (self.joint_known || away.abs() < SCREW_THERE)
            }
            HOME_JOINT => joint.homed,
            STRAIGHTEN => joint.position.angle().to_bits().unsigned_abs() < JOINT_THERE,
            _ => self.tight(drives, now_us),
        }
    }

    fn goal(&self, phase: Phase, drive: usize) -> Goal {
        match (phase, drive) {
            (Phase::Armed | Phase::Starting(_), LEFT) => {
                Goal::Velocity(self.track_speed(0.5 * self.gauge))
            }
            (Phase::Armed | Phase::Starting(_), RIGHT) => {
                Goal::Velocity(self.track_speed(-0.5 * self.gauge))
            }
            (Phase::Armed | Phase::Starting(TIGHTEN), JOINT) => {
                Goal::Position(Target::Angle(self.chassis.position.angle()))
            }
            (Phase::Starting(TIGHTEN), _) => Goal::Belt(0.0),
            (Phase::Armed, _) => Goal::Belt(self.slack),
            (Phase::Starting(HOME_SCREW), SCREW) if !self.screw_known => Goal::Home,
            (Phase::Starting(_), SCREW) => Goal::MoveTo(Target::Length(self.released)),
            (Phase::Starting(HOME_JOINT), JOINT) => Goal::Home,
            (Phase::Starting(STRAIGHTEN), JOINT) => Goal::MoveTo(Target::Angle(Angle::ZERO)),
            // The belts keep their slack, or stay taut, as long as the screw can keep them so.
            (Phase::Held, SCREW) if self.keeps_slack => Goal::Belt(self.slack),
            (Phase::Starting(_) | Phase::Held, _) => Goal::Hold,
        }
    }

    /// Torque feed-forward for the front part's load, while the joint follows its set-point and the
    /// screw the law of the belts.
    fn offsets(&self, phase: Phase, attitude: &Attitude) -> Vec<Offset, MAX_OFFSETS> {
        if !matches!(phase, Phase::Armed | Phase::Starting(TIGHTEN)) {
            return Vec::new();
        }
        let theta = self.chassis.position.angle();
        let extension = self.extension_at(theta, self.slack);
        let curve = self.slack_law.second_derivative(extension, self.slack);
        let load = self.front.load(extension, curve, &self.chassis, attitude);
        [(JOINT, load.joint), (SCREW, load.screw)]
            .into_iter()
            .map(|(drive, load)| Offset { drive, load })
            .collect()
    }

    fn speed(&self) -> f32 {
        self.forward.velocity
    }

    fn stopping_time(&self) -> f32 {
        self.forward.velocity.abs() / self.speed.acceleration
    }

    /// Rounded to the resolution of the bus, so that the reported posture is the one that a stop
    /// holds.
    fn posture(&self) -> Front {
        let front = Front {
            angle: self.chassis.position.angle(),
            slack: self.slack,
        };
        Front {
            slack: self.slack,
            ..Front::from_word(front.word())
        }
    }

    fn slack(&self) -> [f32; 2] {
        [self.slack, self.measured_slack]
    }

    fn belt_tension(&self) -> f32 {
        self.belt_tension
    }

    fn odometry_um(&self) -> i32 {
        self.odometry.um()
    }

    fn joints(&self, drives: &[DriveState]) -> [Joint; 2] {
        let joint = |drive: usize, value: fn(Position) -> f32| Joint {
            value: value(drive_of(drives, drive).position),
            received_us: drive_of(drives, drive)
                .received_us
                .filter(|_| drive_of(drives, drive).homed),
        };
        [
            joint(JOINT, |position| position.angle().radians()),
            joint(SCREW, |position| position.metres() - AXLE_3_FROM_BODY_3),
        ]
    }
}
