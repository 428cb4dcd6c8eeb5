//! Implements the guard's interface to a robot for the cart.

use super::model::{Shape, wheel_rates};
use crate::bus::scale::{Position, Scale};
use crate::motor::profile::{Limits, Motion};
use crate::robots::body::{
    Ahead, Allowed, Body, Command, DriveState, Goal, MAX_DRIVES, Phase, drive_of,
};
use crate::robots::odometry::Odometry;
use crate::robots::turn::Turn;
use crate::settings::{Setting, Settings};
use crate::estimate::attitude::Attitude;
use crate::stability::support::Stance;
use core::convert::Infallible;
use heapless::Vec;

/// State of the cart in the guard. The drives are the left and the right wheel.
#[derive(Clone, Debug)]
pub struct Cart {
    shape: Shape,
    wheel_radius: f32,
    gauge: f32,
    limits: Limits,

    positions: Option<[Position; 2]>,
    odometry: Odometry,
    /// Forward speed that the guard passes; its position is not used.
    forward: Motion,
    turn: Turn,
    wheels: [f32; 2],
}

impl Body for Cart {
    type Refusal = Infallible;
    type Posture = ();

    const STAGES: &'static [&'static str] = &["enabling"];
    const ODOMETRY: &'static [usize] = &[0, 1];
    const GYRATION: f32 = 0.02;

    fn new(settings: &Settings) -> Result<Self, Infallible> {
        let gauge = settings.si(Setting::TrackGauge);
        Ok(Self {
            shape: Shape::new(settings),
            wheel_radius: settings.si(Setting::PulleyRadius),
            gauge,
            limits: Limits {
                velocity: settings.si(Setting::SpeedLimit),
                acceleration: settings.si(Setting::DriveAcceleration),
            },
            positions: None,
            odometry: Odometry::default(),
            forward: Motion::default(),
            turn: Turn::new(0.5 * gauge, settings),
            wheels: [0.0; 2],
        })
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

    fn observe(&mut self, drives: &[DriveState], _: &Attitude, _: f32) {
        let positions = [0, 1].map(|side| drive_of(drives, side).position);
        let before = self.positions.replace(positions).unwrap_or(positions);
        let [left, right] = [0, 1].map(|side: usize| positions[side].turns_since(before[side]));
        let turned = 0.5 * (left + right) * core::f32::consts::TAU;
        self.odometry.add(turned * self.wheel_radius * 1e6);
    }

    fn stance(&self, attitude: &Attitude) -> Stance {
        let axes = attitude.level_axes();
        let [caster, right, left] = self.shape.contacts.map(|place| axes.of(place));
        // The caster is the only rear contact.
        Stance::on_some(
            [Some(caster), Some(right), Some(left), None],
            axes.of(self.shape.cog),
        )
    }

    fn stance_ahead(&self, _: &Command<()>, _: &Attitude, _: f32, _: f32) -> Option<Ahead> {
        None
    }

    fn rest(&mut self) {
        self.forward = Motion::default();
        self.turn.rest();
        self.wheels = [0.0; 2];
    }

    fn advance(&mut self, asked: &Command<()>, allowed: Allowed, _: &Attitude, period: f32) {
        let asked = self.turn.within(*asked);
        allowed.ramp(&mut self.forward, asked.forward, self.limits, period);
        let speed = self.forward.velocity;
        let yaw_rate = allowed.yaw_rate_on_the_curve(&asked, speed);
        let yaw_rate = self.turn.advance(yaw_rate, speed, &allowed, period);
        self.wheels = wheel_rates(self.wheel_radius, self.gauge, speed, yaw_rate);
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
            Phase::Armed => Goal::Velocity(self.wheels[drive & 1]),
        }
    }

    fn speed(&self) -> f32 {
        self.forward.velocity
    }

    fn stopping_time(&self) -> f32 {
        self.forward.velocity.abs() / self.limits.acceleration
    }

    fn posture(&self) {}

    fn odometry_um(&self) -> i32 {
        self.odometry.um()
    }
}
