//! Hylos' nodes, sixteen axles (four per leg) and the guard: their ids, settings and motors.

use super::plant::HylosParameters;
use super::section::Hylos;
use crate::robots::motors::three_phase;
use crate::robots::section::SENSORS;
use crate::robots::{Conditions, NodeName, NodeSpec, Role};
use tautrack::link::MotorModel;
use tautrack::robots::hylos::controller::{LEG_RATE, STEERING_RATE, WHEEL_RATE};
use tautrack::robots::hylos::parameters::{HIP_RANGE, KNEE_RANGE, STEERING_RANGE};
use tautrack::settings::Setting;

impl NodeName {
    /// Hip of the front left leg.
    pub const FRONT_LEFT_HIP: Self = Self::new("front_left_hip");
    /// Knee of the front left leg.
    pub const FRONT_LEFT_KNEE: Self = Self::new("front_left_knee");
    /// Steering of the front left leg.
    pub const FRONT_LEFT_STEERING: Self = Self::new("front_left_steering");
    /// Hip of the front right leg.
    pub const FRONT_RIGHT_HIP: Self = Self::new("front_right_hip");
    /// Knee of the front right leg.
    pub const FRONT_RIGHT_KNEE: Self = Self::new("front_right_knee");
    /// Steering of the front right leg.
    pub const FRONT_RIGHT_STEERING: Self = Self::new("front_right_steering");
    /// Hip of the rear left leg.
    pub const REAR_LEFT_HIP: Self = Self::new("rear_left_hip");
    /// Knee of the rear left leg.
    pub const REAR_LEFT_KNEE: Self = Self::new("rear_left_knee");
    /// Steering of the rear left leg.
    pub const REAR_LEFT_STEERING: Self = Self::new("rear_left_steering");
    /// Hip of the rear right leg.
    pub const REAR_RIGHT_HIP: Self = Self::new("rear_right_hip");
    /// Knee of the rear right leg.
    pub const REAR_RIGHT_KNEE: Self = Self::new("rear_right_knee");
    /// Steering of the rear right leg.
    pub const REAR_RIGHT_STEERING: Self = Self::new("rear_right_steering");
}

/// Names and ids of the nodes, in the order of the plant's motors; the guard is last.
pub const NODES: [(NodeName, u8); 17] = [
    (NodeName::FRONT_LEFT_HIP, 2),
    (NodeName::FRONT_LEFT_KNEE, 3),
    (NodeName::FRONT_LEFT_STEERING, 4),
    (NodeName::FRONT_LEFT_WHEEL, 5),
    (NodeName::FRONT_RIGHT_HIP, 6),
    (NodeName::FRONT_RIGHT_KNEE, 7),
    (NodeName::FRONT_RIGHT_STEERING, 8),
    (NodeName::FRONT_RIGHT_WHEEL, 9),
    (NodeName::REAR_LEFT_HIP, 10),
    (NodeName::REAR_LEFT_KNEE, 11),
    (NodeName::REAR_LEFT_STEERING, 12),
    (NodeName::REAR_LEFT_WHEEL, 13),
    (NodeName::REAR_RIGHT_HIP, 14),
    (NodeName::REAR_RIGHT_KNEE, 15),
    (NodeName::REAR_RIGHT_STEERING, 16),
    (NodeName::REAR_RIGHT_WHEEL, 17),
    (NodeName::GUARD, 1),
];
/// Period of SYNC, us. With seventeen nodes it leaves a fifth of the bus time free.
const SYNC_PERIOD: (Setting, i32) = (Setting::SyncPeriod, 8_000);

/// Returns the specification of every node: role, id, settings and motor.
pub fn nodes(robot: &Hylos, conditions: &Conditions) -> Vec<NodeSpec> {
    let parameters = robot.parameters(conditions.friction);
    let specs = NODES.into_iter().enumerate().map(|(number, (name, id))| {
        if name == NodeName::GUARD {
            return NodeSpec {
                name,
                role: Role::Guard,
                id,
                settings: guard(robot, &parameters, conditions.guard),
                motor: None,
            };
        }
        let axle = Axle::of(number, &parameters);
        NodeSpec {
            name,
            role: Role::Axle,
            id,
            settings: axle.settings(),
            motor: None,
        }
        .with_motor(Some(axle.motor()))
    });
    specs.collect()
}

/// Properties in which the kinds of axle differ.
struct Axle {
    gear_ratio: i32,
    friction_torque: f32,
    brake_torque: f32,
    velocity_limit: f64,
    acceleration_limit: i32,
    velocity_gain: i32,
    position_bits: i32,
    /// Range, rad, and angle at which the home switch opens, rad; `None` for a wheel.
    travel: Option<([f64; 2], f64)>,
}

impl Axle {
    /// Returns the axle of motor `number`, in the plant's order.
    fn of(number: usize, p: &HylosParameters) -> Self {
        // Hip or knee: J = 0.225 (rotor) + 0.25 (a quarter of the robot) kg m^2, T = 6 N m/A, w =
        // 130 rad/s (inertia, torque per ampere and bandwidth of the velocity loop, whose gain is J
        // w / T).
        let joint = |range, reference| Self {
            gear_ratio: 150_000,
            friction_torque: 1.0,
            brake_torque: 60.0,
            velocity_limit: 2.0 * LEG_RATE,
            acceleration_limit: 10_000,
            velocity_gain: 10_000,
            position_bits: 24,
            travel: Some((range, reference)),
        };
        // Wheel: J = 0.036 (rotor) + 0.035 (a quarter of the robot at the tyre) kg m^2, T = 2.4 N
        // m/A, w = 100 rad/s.
        let wheel = Self {
            gear_ratio: 60_000,
            friction_torque: 0.3,
            brake_torque: 0.0,
            velocity_limit: 1.05 * WHEEL_RATE,
            acceleration_limit: 120_000,
            velocity_gain: 3_000,
            position_bits: 16,
            travel: None,
        };
        match number % 4 {
            0 => joint(HIP_RANGE, p.initial_leg[0]),
            1 => joint(KNEE_RANGE, p.initial_leg[1]),
            // Steering: the same motor as the wheel's. It moves little more than its own rotor.
            2 => Self {
                velocity_limit: 2.0 * STEERING_RATE,
                position_bits: 24,
                travel: Some((STEERING_RANGE, 0.0)),
                ..wheel
            },
            _ => wheel,
        }
    }

    fn settings(&self) -> Vec<(Setting, i32)> {
        let milli = |value: f64| (value * 1e3).round() as i32;
        let mut settings = vec![
            SYNC_PERIOD,
            (Setting::VelocityLimit, milli(self.velocity_limit)),
            (Setting::AccelerationLimit, self.acceleration_limit),
            (Setting::VelocityGain, self.velocity_gain),
            (Setting::PositionBits, self.position_bits),
        ];
        if self.brake_torque > 0.0 {
            settings.extend([
                (Setting::BrakeReleaseTime, 40),
                (Setting::BrakeEngageTime, 30),
            ]);
        }
        if let Some(([least, most], reference)) = self.travel {
            settings.extend([
                (Setting::PositionMinimum, milli(least)),
                (Setting::PositionMaximum, milli(most)),
                (Setting::HomingDirection, -1),
                (Setting::HomePosition, milli(reference * 1e3)),
                (Setting::HomingSpeed, 300),
                // All legs are homed at the same time while the robot stands. The weight on a leg
                // shifts between its two approaches to the home switch, and its gear bends by up to
                // 13 mrad more or less.
                (Setting::HomingTolerance, 50),
            ]);
        }
        settings
    }

    /// Returns the motor model. Besseron et al. do not specify the motors. These have three phases,
    /// and the size that 25 kg on legs of 0.4 m require (24 V; stall torque at 10 A: leg 60 N m,
    /// steering and wheel 24 N m). Hips and knees have brakes, which hold the robot without power.
    fn motor(&self) -> MotorModel {
        MotorModel {
            brake_torque: self.brake_torque,
            ..three_phase(self.gear_ratio, self.friction_torque)
        }
    }
}

fn guard(robot: &Hylos, p: &HylosParameters, filters: bool) -> Vec<(Setting, i32)> {
    let micro = |value: f64| (value * 1e6).round() as i32;
    let mass = p.measures.platform_mass + 4.0 * p.measures.wheel_mass;
    let mut values = vec![
        SYNC_PERIOD,
        (Setting::FilterActive, i32::from(filters)),
        (Setting::FirstDriveId, i32::from(NODES[0].1)),
        (Setting::PostureControl, i32::from(robot.posture_control)),
        (Setting::DriveAcceleration, micro(robot.acceleration_mps2)),
        (Setting::RobotMass, micro(mass * 1e-3)),
    ];
    values.extend_from_slice(LEVELS);
    values.extend_from_slice(SENSORS);
    values
}

/// Margin levels. They are below the margins at which posture control holds the robot on a steep
/// slope.
const LEVELS: &[(Setting, i32)] = &[
    (Setting::CautionMargin, 45_000),
    (Setting::StopMargin, 30_000),
    (Setting::TripMargin, 10_000),
    (Setting::BandHysteresis, 3_000),
    (Setting::StopAngle, 40),
];
