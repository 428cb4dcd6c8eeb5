//! Implements [`Body`] for RT-Mover: nine drives with consecutive node ids; the operator's posture
//! word is the height of the step ahead in mm.
//!
//! A word that rises from zero starts the step-up gait. Zero freezes the gait; a wheel in the air
//! stays there. After the gait has ended, the robot follows speed commands again only after the
//! operator's reset. The guard's boards sit on the seat, so its attitude is that of the seat.

use super::gait::Stage;
use super::parameters::{LENGTHS, MASSES, Masses, Parameters, ParametersError};
use super::projection::Projection;
use super::support::cog;
use super::walk::{Gait, Inputs, Outputs, Pace};
use super::wheel::{Shape, Wheel};
use crate::bus::scale::{Position, Scale, Target, from_milli, millimetres};
use crate::estimate::attitude::Attitude;
use crate::math::vector::Vector as Vector3;
use crate::math::{limit, min};
use crate::motor::profile::{Limits, Motion};
use crate::robots::body::{
    Ahead, Allowed, Body, Command, DriveState, Goal, MAX_DRIVES, Phase, PostureCommand, drive_of,
};
use crate::robots::odometry::Odometry;
use crate::settings::{Setting, Settings};
use crate::stability::support::Stance;
use crate::units::Angle;
use heapless::Vec;

/// Order of the drives: four wheels as [`Wheel`], front and rear steering, front and rear roll,
/// pitch.
const DRIVES: usize = 9;
const STEERING: usize = 4;
const ROLL: usize = 6;
const PITCH: usize = 8;

/// Angle below which a steering shaft counts as straight, rad (0.3 degree).
const STRAIGHT: f32 = 5.236e-3;

/// First of the stages of [`Body::STAGES`]: all shafts are homed at once. Their home position is
/// where they stand on level ground.
const HOME: u8 = 0;

/// Commanded height of the step ahead, m; its word counts millimetres.
///
/// A height above zero after [`StepHeight::NONE`] starts the step-up gait.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct StepHeight(pub f32);

impl StepHeight {
    /// No step: the robot drives; a gait that has begun stands still.
    pub const NONE: Self = Self(0.0);
}

impl PostureCommand for StepHeight {
    fn from_word(millimetres: i16) -> Self {
        Self(from_milli(millimetres))
    }

    fn word(self) -> i16 {
        millimetres(self.0)
    }
}

/// RT-Mover, the leg-wheel robot, under the guard.
#[derive(Clone, Debug)]
pub struct RtMover {
    parameters: Parameters<f32>,
    /// Distance by which a declared load moves the centre of gravity to the left, m. It affects the
    /// gait through the guard's margins only.
    cog_left: f32,
    speed: Limits,
    gait: Gait,
    inputs: Inputs,
    outputs: Outputs,
    known: [bool; DRIVES],
    /// Heading at which the robot faces the step straight.
    straight: Angle,
    /// Step height of the previous command.
    step_height: StepHeight,
    /// Forward speed that is passed on; the position of this motion is not used.
    forward: Motion,
    wheels: Option<[Position; 4]>,
    odometry: Odometry,
}

impl RtMover {
    fn stance_of(&self, shape: &Shape<f32>, attitude: &Attitude) -> Stance {
        let (sine, cosine) = crate::math::sin_cos(attitude.roll());
        // Transforms right, forward, up to forward, left, up. Then applies the body's roll about
        // the heading, which the model does not have.
        let level = |[right, forward, up]: Vector3<f32>, left: f32| {
            let left = left - right;
            [
                forward,
                left * cosine - up * sine,
                up * cosine + left * sine,
            ]
        };
        let contacts = Projection::new(&self.parameters, shape).contacts;
        let around = [
            Wheel::RearRight,
            Wheel::FrontRight,
            Wheel::FrontLeft,
            Wheel::RearLeft,
        ];
        let lifted = self.gait.lifted();
        let standing = around
            .map(|wheel| (lifted != Some(wheel)).then(|| level(contacts[wheel as usize & 3], 0.0)));
        Stance::on_some(standing, level(cog(&self.parameters, shape), self.cog_left))
    }

    /// Speed scale of the gait's motion. A small margin does not hold up a wheel that goes down,
    /// because the margin widens when it lands.
    fn speed_scale(&self, asked: &Command<StepHeight>, allowed: &Allowed) -> f32 {
        let posture = if allowed.posture {
            allowed.limits.posture
        } else {
            0.0
        };
        match self.gait.stage() {
            // The forward speed is already scaled.
            Stage::Standing | Stage::Arrived | Stage::Stuck | Stage::Stranded => 1.0,
            _ if asked.posture == StepHeight::NONE || allowed.stop.is_some() => 0.0,
            Stage::Landing => 1.0,
            Stage::Lifting | Stage::Swinging => min(allowed.speed_scale, posture),
            _ => allowed.speed_scale,
        }
    }
}

/// Masses with the declared load, which is fixed to the seat, and the distance by which the load
/// moves the centre of gravity to the left, m.
fn loaded(settings: &Settings) -> (Masses, f32) {
    let load = settings.si_f64(Setting::PayloadMass);
    let seat = MASSES.seat + load;
    let mean = |own: f64, setting| (MASSES.seat * own + load * settings.si_f64(setting)) / seat;
    let masses = Masses {
        seat,
        seat_forward: mean(MASSES.seat_forward, Setting::PayloadForward),
        seat_height: mean(MASSES.seat_height, Setting::PayloadUp),
        ..MASSES
    };
    let left = load * settings.si_f64(Setting::PayloadLeft) / masses.total();
    (masses, left as f32)
}

impl Body for RtMover {
    /// The value that no robot can have. Only its name, because formatting numbers would take
    /// 20 KiB of flash.
    type Refusal = &'static str;
    type Posture = StepHeight;

    const STAGES: &'static [&'static str] = &["homing", "straightening"];
    const ODOMETRY: &'static [usize] = &[0, 1, 2, 3];
    // The masses of `parameters.rs` give about 0.055 m^2, with a load on the seat less.
    const GYRATION: f32 = 0.09;

    fn new(settings: &Settings) -> Result<Self, &'static str> {
        let (masses, cog_left) = loaded(settings);
        let parameters = Parameters::new(&LENGTHS, &masses).map_err(|error| match error {
            ParametersError::OutOfRange { name, .. } => name,
            ParametersError::SteeringLimit { .. } => "steering limit",
        })?;
        Ok(Self {
            parameters,
            cog_left,
            speed: Limits {
                velocity: settings.si(Setting::SpeedLimit),
                acceleration: settings.si(Setting::DriveAcceleration),
            },
            gait: Gait::new(parameters, Pace::nominal()),
            inputs: Inputs::default(),
            outputs: Outputs::default(),
            known: [false; DRIVES],
            straight: Angle::ZERO,
            step_height: StepHeight::NONE,
            forward: Motion::default(),
            wheels: None,
            odometry: Odometry::default(),
        })
    }

    fn drive_ids(settings: &Settings) -> Vec<u8, MAX_DRIVES> {
        let first = settings.id(Setting::FirstDriveId);
        (first..).take(DRIVES).collect()
    }

    fn scale(drive: usize) -> Scale {
        let bits = if drive < STEERING { 16 } else { 24 };
        Scale::Turning { bits }
    }

    fn observe(&mut self, drives: &[DriveState], attitude: &Attitude, _: f32) {
        let angle = |drive: usize| drive_of(drives, drive).position.radians();
        let torque = |drive: usize| drive_of(drives, drive).torque;
        self.known = core::array::from_fn(|drive| drive_of(drives, drive).homed);
        self.inputs = Inputs {
            wheels: [0, 1, 2, 3].map(angle),
            steering: [STEERING, STEERING + 1].map(angle),
            roll: [ROLL, ROLL + 1].map(angle),
            pitch_shaft: angle(PITCH),
            wheel_torques: [0, 1, 2, 3].map(torque),
            roll_torques: [ROLL, ROLL + 1].map(torque),
            inclination: [attitude.pitch().radians(), attitude.roll().radians()],
            ..self.inputs
        };
        let wheels = [0, 1, 2, 3].map(|drive| drive_of(drives, drive).position);
        let before = self.wheels.replace(wheels).unwrap_or(wheels);
        let turned = (0..4).fold(0.0, |sum, wheel| {
            sum + wheels[wheel].turns_since(before[wheel]) * core::f32::consts::TAU
        });
        self.odometry
            .add(0.25e6 * self.parameters.wheel_radius * turned);
    }

    fn stance(&self, attitude: &Attitude) -> Stance {
        self.stance_of(&self.inputs.shape(), attitude)
    }

    fn stance_ahead(
        &self,
        _: &Command<StepHeight>,
        attitude: &Attitude,
        horizon: f32,
        _: f32,
    ) -> Option<Ahead> {
        // The shafts continue at the rates of the last command.
        let mut shape = self.inputs.shape();
        for axle in 0..2 {
            shape.steering[axle] += self.outputs.steering[axle] * horizon;
            shape.roll[axle] += self.outputs.roll[axle] * horizon;
        }
        Some(self.stance_of(&shape, attitude).into())
    }

    fn rest(&mut self) {
        self.forward = Motion::default();
        self.outputs = Outputs::default();
        self.step_height = StepHeight::NONE;
        self.gait.hold();
    }

    fn acknowledge(&mut self) {
        self.gait.acknowledge();
    }

    fn advance(
        &mut self,
        asked: &Command<StepHeight>,
        allowed: Allowed,
        attitude: &Attitude,
        period: f32,
    ) {
        let standing = self.gait.stage() == Stage::Standing;
        // The robot stops before a gait begins.
        let forward = if standing && asked.posture == StepHeight::NONE {
            asked.forward
        } else {
            0.0
        };
        allowed.ramp(&mut self.forward, forward, self.speed, period);
        let risen = asked.posture.0 > 0.0 && self.step_height == StepHeight::NONE;
        if !(risen && standing && self.forward.velocity != 0.0) {
            self.step_height = asked.posture;
            if risen && standing {
                self.straight = attitude.heading();
                self.gait.ask(asked.posture.0, 0.0);
            }
        }
        let speed = self.forward.velocity;
        // At any speed the robot is on the commanded curve.
        let yaw_rate = if asked.forward == 0.0 {
            0.0
        } else {
            limit(
                asked.yaw_rate * (speed / asked.forward),
                asked.yaw_rate.abs(),
            )
        };
        self.inputs.command = Command::new(speed, yaw_rate);
        self.inputs.heading = (attitude.heading() - self.straight).radians();
        self.inputs.speed_scale = self.speed_scale(asked, &allowed);
        let outputs = self.gait.tick(&self.inputs, period);
        self.outputs = if allowed.stop.is_none() {
            outputs
        } else {
            // Levelling and a wheel in the air stop too; a driving robot brakes by its ramp.
            Outputs {
                wheels: if standing { outputs.wheels } else { [0.0; 4] },
                ..Outputs::default()
            }
        };
    }

    fn first_stage(&self, drives: &[DriveState]) -> u8 {
        let known = drives.iter().skip(STEERING).all(|drive| drive.homed);
        HOME + u8::from(known)
    }

    fn reached(&mut self, stage: u8, drives: &[DriveState], _: u64) -> bool {
        let enabled = drives.iter().all(|drive| drive.enabled);
        let mut shafts = drives.iter().skip(STEERING);
        enabled
            && if stage == HOME {
                shafts.all(|drive| drive.homed)
            } else {
                let straight = |drive: &DriveState| drive.position.radians().abs() < STRAIGHT;
                shafts.take(ROLL - STEERING).all(straight)
            }
    }

    fn goal(&self, phase: Phase, drive: usize) -> Goal {
        let Outputs {
            wheels,
            steering,
            roll,
            pitch_shaft,
        } = self.outputs;
        match (phase, drive) {
            (Phase::Held, _) => Goal::Hold,
            (Phase::Starting(HOME), STEERING..DRIVES) if !self.known[drive] => Goal::Home,
            (Phase::Starting(stage), STEERING..ROLL) if stage > HOME => {
                Goal::MoveTo(Target::Radians(0.0))
            }
            (Phase::Starting(_), _) => Goal::Velocity(0.0),
            (Phase::Armed, _) => Goal::Velocity(match drive {
                0..STEERING => wheels[drive],
                STEERING..ROLL => steering[drive - STEERING],
                ROLL..PITCH => roll[drive - ROLL],
                _ => pitch_shaft,
            }),
        }
    }

    fn speed(&self) -> f32 {
        let sum = self.outputs.wheels.iter().fold(0.0, |sum, rate| sum + rate);
        0.25 * self.parameters.wheel_radius * sum
    }

    fn stopping_time(&self) -> f32 {
        self.speed().abs() / self.speed.acceleration
    }

    /// Always no step. As a command, this leaves the gait where it is.
    fn posture(&self) -> StepHeight {
        StepHeight::NONE
    }

    fn odometry_um(&self) -> i32 {
        self.odometry.um()
    }
}
