//! Implements [`Body`] for Hylos: reads its sixteen drives, and computes their set-points for a
//! command.

use super::parameters::{MARGIN_FLOOR, MARGIN_LIMIT, POTENTIAL_GAIN, STANCE_HEIGHT};
use super::{
    Controller, Desired, LEGS, Parameters, Posture, Potential, PotentialError, Sensed, attitude,
    controller,
};
use crate::bus::scale::{Position, Scale, Target, from_milli, millimetres};
use crate::estimate::attitude::Attitude;
use crate::math::sin_cos;
use crate::motor::profile::{Limits, Motion};
use crate::robots::body::{
    Ahead, Allowed, Body, Command, DriveState, Goal, MAX_DRIVES, Phase, PostureCommand, drive_of,
};
use crate::robots::odometry::Odometry;
use crate::robots::turn::Turn;
use crate::settings::{Setting, Settings};
use crate::stability::support::Stance;
use heapless::Vec;

/// Motors of a leg, in the order of their nodes; the legs count front left, front right, rear left,
/// rear right.
const HIP: usize = 0;
const KNEE: usize = 1;
const STEERING: usize = 2;
const WHEEL: usize = 3;
const PER_LEG: usize = 4;

/// First of the stages of [`Body::STAGES`]: hips, knees and steering are homed. Wheels without
/// power roll as the legs move them; wheels that hold go on holding.
const HOME: u8 = 0;

/// Hylos, the wheel-legged robot, under the guard.
#[derive(Clone, Debug)]
pub struct Hylos {
    parameters: Parameters<f32>,
    potential: Potential<f32>,
    speed: Limits,

    controller: Controller<f32>,
    sensed: Sensed<f32>,
    wheels: Option<[Position; LEGS]>,
    odometry: Odometry,
    /// Forward speed that is passed on; the position of this motion is not used.
    forward: Motion,
    turn: Turn,
    clearance: Clearance,
}

impl Hylos {
    fn stands(posture: &Posture<'_, f32>) -> Stance {
        let (cog, contacts) = posture.level();
        Stance::on(contacts, cog)
    }
}

/// Commanded height of the platform's hips above the wheels' centres, m.
///
/// Its word counts millimetres; 0 or less commands the height of the robot's nominal stance.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Clearance(pub f32);

impl Default for Clearance {
    fn default() -> Self {
        Self(STANCE_HEIGHT as f32)
    }
}

impl PostureCommand for Clearance {
    fn from_word(millimetres: i16) -> Self {
        if millimetres > 0 {
            Self(from_milli(millimetres))
        } else {
            Self::default()
        }
    }

    fn word(self) -> i16 {
        millimetres(self.0)
    }
}

impl Body for Hylos {
    type Refusal = PotentialError;
    type Posture = Clearance;

    const STAGES: &'static [&'static str] = &["homing legs", "enabling wheels"];
    const ODOMETRY: &'static [usize] = &[
        WHEEL,
        PER_LEG + WHEEL,
        2 * PER_LEG + WHEEL,
        3 * PER_LEG + WHEEL,
    ];
    // Platform and wheels of `parameters.rs` give about 0.065 m^2 with the legs straight.
    const GYRATION: f32 = 0.09;

    fn new(settings: &Settings) -> Result<Self, PotentialError> {
        let posture_control = settings.get(Setting::PostureControl) == 1;
        let gain = if posture_control { POTENTIAL_GAIN } else { 0.0 };
        let potential = Potential::new(gain, MARGIN_LIMIT, MARGIN_FLOOR)?;
        let parameters = Parameters::nominal();
        let sensed = Sensed {
            legs: [controller::stance(&parameters, STANCE_HEIGHT as f32); LEGS],
            torques: [[0.0; 2]; LEGS],
            steering: [0.0; LEGS],
            up: [0.0, 0.0, 1.0],
            acceleration: [0.0; 3],
        };
        Ok(Self {
            controller: Controller::new(parameters, potential, &sensed),
            parameters,
            potential,
            speed: Limits {
                velocity: settings.si(Setting::SpeedLimit),
                acceleration: settings.si(Setting::DriveAcceleration),
            },
            sensed,
            wheels: None,
            odometry: Odometry::default(),
            forward: Motion::default(),
            turn: Turn::new(Self::half_width(settings), settings),
            clearance: Clearance::default(),
        })
    }

    fn half_width(_: &Settings) -> f32 {
        Parameters::nominal().reach()
    }

    fn drive_ids(settings: &Settings) -> Vec<u8, MAX_DRIVES> {
        let first = settings.id(Setting::FirstDriveId);
        (first..).take(MAX_DRIVES).collect()
    }

    fn scale(drive: usize) -> Scale {
        let bits = if drive % PER_LEG == WHEEL { 16 } else { 24 };
        Scale::Turning { bits }
    }

    fn observe(&mut self, drives: &[DriveState], attitude: &Attitude, _: f32) {
        let (legs, _) = drives.as_chunks::<PER_LEG>();
        let mut wheels = [Position::default(); LEGS];
        for (leg, drives) in legs.iter().enumerate().take(LEGS) {
            // A joint that is not homed is taken to be where it is in the nominal stance.
            let angle = |motor: usize, before: f32| {
                let drive = drive_of(drives, motor);
                if drive.homed {
                    drive.position.radians()
                } else {
                    before
                }
            };
            let [hip, knee] = self.sensed.legs[leg];
            self.sensed.legs[leg] = [angle(HIP, hip), angle(KNEE, knee)];
            self.sensed.steering[leg] = angle(STEERING, self.sensed.steering[leg]);
            self.sensed.torques[leg] = [HIP, KNEE].map(|motor| drive_of(drives, motor).torque);
            wheels[leg] = drive_of(drives, WHEEL).position;
        }
        self.sensed.up =
            attitude::up_from_tilt(sin_cos(attitude.pitch()), sin_cos(attitude.roll()));
        if let Some(before) = self.wheels {
            let turned = wheels.iter().zip(before).fold(0.0, |sum, (now, before)| {
                sum + now.turns_since(before) * (core::f32::consts::TAU / LEGS as f32)
            });
            self.odometry
                .add(turned * self.parameters.wheel_radius() * 1e6);
        }
        self.wheels = Some(wheels);
    }

    fn stance(&self, _: &Attitude) -> Stance {
        Self::stands(&self.controller.posture(&self.sensed))
    }

    fn stance_ahead(
        &self,
        _: &Command<Clearance>,
        _: &Attitude,
        horizon: f32,
        _: f32,
    ) -> Option<Ahead> {
        let ahead = self.controller.ahead(&self.sensed, horizon);
        Some(Self::stands(&self.controller.posture(&ahead)).into())
    }

    fn rest(&mut self) {
        self.forward = Motion::default();
        self.turn.rest();
        self.controller = Controller::new(self.parameters, self.potential, &self.sensed);
    }

    /// Moves the set-points. When the legs correct a small margin, this counts as motion of the
    /// posture: it passes while it raises the margins.
    fn advance(&mut self, asked: &Command<Clearance>, allowed: Allowed, _: &Attitude, period: f32) {
        let driven = self.turn.within(*asked);
        allowed.ramp(&mut self.forward, driven.forward, self.speed, period);
        let speed = self.forward.velocity;
        let yaw_rate = allowed.yaw_rate_on_the_curve(&driven, speed);
        let yaw_rate = self.turn.advance(yaw_rate, speed, &allowed, period);
        if allowed.posture {
            self.clearance = asked.posture;
        }
        let desired = Desired {
            forward: speed,
            yaw_rate,
            clearance: Some(self.clearance.0),
        };
        self.controller.hold_legs(!allowed.posture);
        self.controller.step(&self.sensed, &desired, period);
    }

    fn first_stage(&self, drives: &[DriveState]) -> u8 {
        // If every drive is homed already, wheels that hold keep holding.
        HOME + u8::from(drives.iter().all(|drive| drive.homed))
    }

    fn reached(&mut self, stage: u8, drives: &[DriveState], _: u64) -> bool {
        if stage == HOME {
            drives.iter().all(|drive| drive.homed)
        } else {
            drives.iter().all(|drive| drive.enabled)
        }
    }

    fn goal(&self, phase: Phase, drive: usize) -> Goal {
        let points = self.controller.set_points();
        let (leg, motor) = (drive / PER_LEG % LEGS, drive % PER_LEG);
        let joint = |angle: f32| Goal::Position(Target::Radians(angle));
        match (phase, motor) {
            (Phase::Held, _) | (Phase::Starting(HOME), WHEEL) => Goal::Hold,
            (Phase::Starting(_), WHEEL) => Goal::Velocity(0.0),
            (Phase::Starting(_), _) => Goal::Home,
            (Phase::Armed, HIP | KNEE) => joint(points.legs[leg][motor]),
            (Phase::Armed, STEERING) => joint(points.steering[leg]),
            (Phase::Armed, _) => Goal::Velocity(points.wheel_rates[leg]),
        }
    }

    fn speed(&self) -> f32 {
        self.forward.velocity
    }

    fn stopping_time(&self) -> f32 {
        self.forward.velocity.abs() / self.speed.acceleration
    }

    fn posture(&self) -> Clearance {
        self.clearance
    }

    /// Mean travel of the four wheels, each along its own path.
    fn odometry_um(&self) -> i32 {
        self.odometry.um()
    }
}
