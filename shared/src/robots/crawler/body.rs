//! Implements [`Body`] for the crawler: its stance, and the rates of its sprockets for a command.

use super::controller::{Configuration, Controller, Observation, STANDING};
use super::kinematics::BodyVelocity;
use super::parameters::{Dimensions, Ground, Masses, ParametersError};
use super::shape::Shape;
use crate::bus::scale::{Position, Scale};
use crate::estimate::attitude::Attitude;
use crate::math::Scalar;
use crate::motor::profile::{Limits, Motion};
use crate::robots::body::{
    Ahead, Allowed, Body, Command, DriveState, Goal, MAX_DRIVES, Phase, drive_of,
};
use crate::robots::odometry::Odometry;
use crate::robots::turn::Turn;
use crate::settings::{Setting, Settings};
use crate::stability::support::Stance;
use heapless::Vec;

/// Minimum cosine of the pitch at which the speed along the level heading determines the speed
/// along the robot.
const LEAST_COSINE: f32 = 0.3;

/// The crawler, a tracked robot on soft ground, under the guard.
#[derive(Clone, Debug)]
pub struct Crawler {
    shape: Shape,
    controller: Controller,
    speed: Limits,
    measures_speed: bool,

    positions: Option<[Position; 2]>,
    measured_speed: Option<f32>,
    odometry: Odometry,
    /// Forward speed that is passed on; the position of this motion is not used.
    forward: Motion,
    turn: Turn,
    sprockets: [f32; 2],
}

impl Body for Crawler {
    type Refusal = ParametersError;
    type Posture = ();

    const STAGES: &'static [&'static str] = &["enabling"];
    const ODOMETRY: &'static [usize] = &[0, 1];
    // A box of 0.20 by 0.19 by 0.08 m (5 kg), and 2.5 kg 0.21 m above its centre of gravity.
    const GYRATION: f32 = 0.014;

    fn new(settings: &Settings) -> Result<Self, ParametersError> {
        let si = |setting| settings.si_f64(setting);
        let dimensions = Dimensions {
            sprocket_radius: si(Setting::PulleyRadius),
            track_spacing: si(Setting::TrackGauge),
            contact_length: si(Setting::ContactLength),
            track_width: si(Setting::TrackWidth),
            gear_ratio: si(Setting::GearRatio),
        };
        let masses = Masses {
            mass: si(Setting::RobotMass),
            cog: [0.0, 0.0, si(Setting::CogHeight)],
        };
        let payload = [
            Setting::PayloadForward,
            Setting::PayloadLeft,
            Setting::PayloadUp,
        ];
        let masses = masses.loaded(si(Setting::PayloadMass), payload.map(si));
        let compensation = settings.get(Setting::SlipCompensation);
        // Belts that compensate slip run faster than the robot moves over ground, by an unknown
        // amount.
        let sprocket_limit = si(Setting::VelocityLimit);
        let over_ground = si(Setting::SpeedLimit) / dimensions.sprocket_radius;
        let controller = Controller::new(&Configuration {
            dimensions,
            body: masses,
            ground: Ground {
                cohesion: si(Setting::SoilCohesion),
                friction_angle: si(Setting::SoilFrictionAngle),
                k1: si(Setting::SoilK1),
                k2: si(Setting::SoilK2),
            },
            compensates_slip: compensation > 0,
            sprocket_limit: if compensation == 0 && over_ground < sprocket_limit {
                over_ground
            } else {
                sprocket_limit
            },
        })?;
        Ok(Self {
            shape: Shape::new(&dimensions, &masses)?,
            controller,
            speed: Limits {
                velocity: settings.si(Setting::SpeedLimit),
                acceleration: settings.si(Setting::DriveAcceleration),
            },
            measures_speed: compensation > 1,
            positions: None,
            measured_speed: None,
            odometry: Odometry::default(),
            forward: Motion::default(),
            turn: Turn::new(Self::half_width(settings), settings),
            sprockets: [0.0; 2],
        })
    }

    fn half_width(settings: &Settings) -> f32 {
        0.5 * settings.si(Setting::TrackGauge)
    }

    fn drive_ids(settings: &Settings) -> Vec<u8, MAX_DRIVES> {
        [Setting::LeftId, Setting::RightId]
            .into_iter()
            .map(|setting| settings.id(setting))
            .collect()
    }

    fn scale(_: usize) -> Scale {
        Scale::Turning { bits: 16 }
    }

    fn receive_speed(&mut self, along_heading: f32, attitude: &Attitude) {
        let (_, level) = Scalar::sin_cos(attitude.pitch().radians());
        self.measured_speed =
            (self.measures_speed && level > LEAST_COSINE).then(|| along_heading / level);
    }

    fn observe(&mut self, drives: &[DriveState], attitude: &Attitude, period: f32) {
        let positions = [0, 1].map(|side| drive_of(drives, side).position);
        let before = self.positions.replace(positions).unwrap_or(positions);
        // From positions instead of rates, because the sum of position differences is exact.
        let sprockets = [0, 1].map(|side: usize| {
            positions[side].turns_since(before[side]) * (core::f32::consts::TAU / period)
        });
        self.controller.observe(
            &Observation {
                sprockets,
                heading: attitude.heading().radians(),
                pitch: attitude.pitch().radians(),
                roll: attitude.roll().radians(),
                measured_speed: self.measured_speed.take(),
            },
            period,
        );
        self.odometry
            .add(self.controller.velocity().forward * period * 1e6);
    }

    fn stance(&self, attitude: &Attitude) -> Stance {
        let axes = attitude.level_axes();
        let shape = self.shape.turned(|point| axes.of(point));
        Stance::on(shape.contacts, shape.cog)
    }

    fn stance_ahead(&self, _: &Command<()>, _: &Attitude, _: f32, _: f32) -> Option<Ahead> {
        None
    }

    fn rest(&mut self) {
        self.forward = Motion::default();
        self.turn.rest();
        // A new path begins where the robot is.
        self.sprockets = self.controller.command(STANDING, 0.0).sprockets;
    }

    fn advance(&mut self, asked: &Command<()>, allowed: Allowed, _: &Attitude, period: f32) {
        let asked = self.turn.within(*asked);
        allowed.ramp(&mut self.forward, asked.forward, self.speed, period);
        let speed = self.forward.velocity;
        let yaw_rate = allowed.yaw_rate_on_the_curve(&asked, speed);
        let yaw_rate = self.turn.advance(yaw_rate, speed, &allowed, period);
        let velocity = BodyVelocity {
            forward: speed,
            yaw_rate,
        };
        self.sprockets = self.controller.command(velocity, period).sprockets;
    }

    fn first_stage(&self, _: &[DriveState]) -> u8 {
        0
    }

    fn reached(&mut self, _: u8, drives: &[DriveState], _: u64) -> bool {
        drives.iter().all(|drive| drive.enabled)
    }

    fn goal(&self, phase: Phase, drive: usize) -> Goal {
        match phase {
            Phase::Held => Goal::Hold,
            Phase::Starting(_) => Goal::Velocity(0.0),
            Phase::Armed => Goal::Velocity(self.sprockets[drive & 1]),
        }
    }

    fn speed(&self) -> f32 {
        self.forward.velocity
    }

    fn stopping_time(&self) -> f32 {
        self.forward.velocity.abs() / self.speed.acceleration
    }

    fn posture(&self) {}

    fn odometry_um(&self) -> i32 {
        self.odometry.um()
    }
}
