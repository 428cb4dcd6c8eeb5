//! Hylos under the guard: what the bus shows of sixteen drives, what the operator's command becomes, and the set-points that follow from it.

use super::parameters::{MARGIN_FLOOR, MARGIN_LIMIT, POTENTIAL_GAIN, STANCE_HEIGHT};
use super::{Controller, LEGS, Parameters, Posture, Sensed, Wish, attitude, body};
use crate::math::{sin_cos, to_i16, to_i32};
use crate::motor::profile::{Limits, SetPoint as Motion};
use crate::node::scale::Scale;
use crate::robots::body::{
    Ahead, Allowed, Asked, Body, DriveState, Goal, MAX_DRIVES, Phase, drive_of,
};
use crate::robots::turn::Turn;
use crate::settings::{Setting, Settings};
use crate::stability::attitude::Attitude;
use crate::stability::support::Stance;
use crate::stability::tipover::{Potential, PotentialError};
use heapless::Vec;

/// Motors of a leg, in the order of their nodes; the legs count front left, front right, rear left, rear right.
const HIP: usize = 0;
const KNEE: usize = 1;
const STEERING: usize = 2;
const WHEEL: usize = 3;
const PER_LEG: usize = 4;

/// Radians per bit of hips, knees and steering, 2^-24 turn, and of wheels, 2^-16 turn.
const JOINT_RADIANS: f32 = core::f32::consts::TAU / 16_777_216.0;
const WHEEL_RADIANS: f32 = core::f32::consts::TAU / 65_536.0;
/// Unit of a drive's torque, N m.
const TORQUE: f32 = 0.01;

/// The stages of [`Body::STAGES`]. While hips and knees look for their references the wheels roll freely, as the legs move them.
const REFERENCE: u8 = 0;

/// The wheel-legged robot under the guard.
#[derive(Clone, Debug)]
pub struct Hylos {
    parameters: Parameters<f32>,
    potential: Potential<f32>,
    speed: Limits,

    controller: Controller<f32>,
    sensed: Sensed<f32>,
    wheels: Option<[i32; LEGS]>,
    odometry_um: f32,
    odometry_whole_um: i32,
    /// Forward speed that is passed on; its position is not used.
    forward: Motion,
    turn: Turn,
    /// The wished clearance, m.
    clearance: f32,
}

impl Hylos {
    fn stands(posture: &Posture<'_, f32>) -> Stance {
        let (cog, contacts) = posture.level();
        Stance::on(contacts, cog)
    }
}

/// Height in m of a clearance in mm as the operator gives it; 0 or less is the height at which the robot just stands.
fn clearance(millimetres: i16) -> f32 {
    if millimetres > 0 {
        f32::from(millimetres) * 1e-3
    } else {
        STANCE_HEIGHT as f32
    }
}

impl Body for Hylos {
    type Refusal = PotentialError;

    const STAGES: &'static [&'static str] = &["referencing legs", "enabling wheels"];
    const ODOMETRY: &'static [usize] = &[
        WHEEL,
        PER_LEG + WHEEL,
        2 * PER_LEG + WHEEL,
        3 * PER_LEG + WHEEL,
    ];

    fn new(settings: &Settings) -> Result<Self, PotentialError> {
        let posture_control = settings.get(Setting::PostureControl) == 1;
        let gain = if posture_control { POTENTIAL_GAIN } else { 0.0 };
        let potential = Potential::new(gain, MARGIN_LIMIT, MARGIN_FLOOR)?;
        let parameters = Parameters::nominal();
        let sensed = Sensed {
            legs: [body::stance(&parameters, STANCE_HEIGHT as f32); LEGS],
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
                velocity: settings.scaled(Setting::SpeedLimit, 1e-6),
                acceleration: settings.scaled(Setting::DriveAcceleration, 1e-6),
            },
            sensed,
            wheels: None,
            odometry_um: 0.0,
            odometry_whole_um: 0,
            forward: Motion::default(),
            turn: Turn::new(parameters.reach(), settings),
            clearance: STANCE_HEIGHT as f32,
        })
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
        let mut wheels = [0; LEGS];
        for (leg, drives) in legs.iter().enumerate().take(LEGS) {
            // A joint without reference is taken to be where it is when the robot just stands.
            let angle = |motor: usize, before: f32| {
                let drive = drive_of(drives, motor);
                if drive.referenced {
                    drive.position as f32 * JOINT_RADIANS
                } else {
                    before
                }
            };
            let [hip, knee] = self.sensed.legs[leg];
            self.sensed.legs[leg] = [angle(HIP, hip), angle(KNEE, knee)];
            self.sensed.steering[leg] = angle(STEERING, self.sensed.steering[leg]);
            self.sensed.torques[leg] =
                [HIP, KNEE].map(|motor| f32::from(drive_of(drives, motor).torque) * TORQUE);
            wheels[leg] = drive_of(drives, WHEEL).position;
        }
        self.sensed.up =
            attitude::up_from_tilt(sin_cos(attitude.pitch()), sin_cos(attitude.roll()));
        if let Some(before) = self.wheels {
            let turned = wheels.iter().zip(before).fold(0.0, |sum, (now, before)| {
                sum + now.wrapping_sub(before) as f32 * (WHEEL_RADIANS / LEGS as f32)
            });
            // Whole micrometres leave the sum, so that it never grows coarse.
            self.odometry_um += turned * self.parameters.wheel_radius() * 1e6;
            let whole = to_i32(self.odometry_um);
            self.odometry_um -= whole as f32;
            self.odometry_whole_um = self.odometry_whole_um.wrapping_add(whole);
        }
        self.wheels = Some(wheels);
    }

    fn stance(&self, _: &Attitude) -> Stance {
        Self::stands(&self.controller.posture(&self.sensed))
    }

    fn stance_ahead(&self, _: &Asked, _: &Attitude, horizon: f32, _: f32) -> Option<Ahead> {
        let ahead = self.controller.ahead(&self.sensed, horizon);
        Some(Self::stands(&self.controller.posture(&ahead)).into())
    }

    fn rest(&mut self) {
        self.forward = Motion::default();
        self.turn.rest();
        self.controller = Controller::new(self.parameters, self.potential, &self.sensed);
    }

    /// The legs' way out of danger counts as motion of the posture: it passes while it raises the margins.
    fn advance(&mut self, asked: &Asked, allowed: Allowed, _: &Attitude, period: f32) {
        let driven = self.turn.within(*asked);
        allowed.ramp(&mut self.forward, driven.forward, self.speed, period);
        let speed = self.forward.velocity;
        let yaw_rate = allowed.yaw_rate_on_the_curve(&driven, speed);
        let yaw_rate = self.turn.advance(yaw_rate, speed, &allowed, period);
        if allowed.posture {
            self.clearance = clearance(asked.posture);
        }
        let wish = Wish {
            forward: speed,
            yaw_rate,
            clearance: Some(self.clearance),
        };
        self.controller.hold_legs(!allowed.posture);
        self.controller.step(&self.sensed, &wish, period);
    }

    fn first_stage(&self, drives: &[DriveState]) -> u8 {
        // Wheels that hold go on holding where nothing is to be homed.
        REFERENCE + u8::from(drives.iter().all(|drive| drive.referenced))
    }

    fn reached(&mut self, stage: u8, drives: &[DriveState], _: u64) -> bool {
        if stage == REFERENCE {
            drives.iter().all(|drive| drive.referenced)
        } else {
            drives.iter().all(|drive| drive.enabled)
        }
    }

    fn goal(&self, phase: Phase, drive: usize) -> Goal {
        let points = self.controller.set_points();
        let (leg, motor) = (drive / PER_LEG % LEGS, drive % PER_LEG);
        let joint = |angle: f32| Goal::Position(to_i32(angle / JOINT_RADIANS));
        match (phase, motor) {
            (Phase::Held, _) => Goal::Hold,
            (Phase::Waking(REFERENCE), WHEEL) => Goal::Off,
            (Phase::Waking(_), WHEEL) => Goal::Velocity(0),
            (Phase::Waking(_), _) => Goal::Reference,
            (Phase::Armed, HIP | KNEE) => joint(points.legs[leg][motor]),
            (Phase::Armed, STEERING) => joint(points.steering[leg]),
            (Phase::Armed, _) => Goal::Velocity(to_i32(points.wheel_rates[leg] * 1e6)),
        }
    }

    fn speed(&self) -> f32 {
        self.forward.velocity
    }

    fn stopping_time(&self) -> f32 {
        self.forward.velocity.abs() / self.speed.acceleration
    }

    /// The wished clearance, mm.
    fn posture(&self) -> i16 {
        to_i16(self.clearance * 1e3)
    }

    /// Mean of the four wheels, along their own ways.
    fn odometry_um(&self) -> i32 {
        self.odometry_whole_um
    }
}
