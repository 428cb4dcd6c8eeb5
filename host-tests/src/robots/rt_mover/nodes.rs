//! RT-Mover's nodes, nine axles and the guard: their ids, settings and motors.

use super::plant::SWITCH;
use super::section::RtMover;
use crate::robots::motors::three_phase;
use crate::robots::payload::Payload;
use crate::robots::section::SENSORS;
use crate::robots::{Conditions, NodeName, NodeSpec, Role};
use tautrack::link::MotorModel;
use tautrack::settings::Setting;

impl NodeName {
    /// Steering shaft of the front arm.
    pub const FRONT_STEERING: Self = Self::new("front_steering");
    /// Steering shaft of the rear arm.
    pub const REAR_STEERING: Self = Self::new("rear_steering");
    /// Roll shaft of the front arm.
    pub const FRONT_ROLL: Self = Self::new("front_roll");
    /// Roll shaft of the rear arm.
    pub const REAR_ROLL: Self = Self::new("rear_roll");
    /// Pitch shaft under the seat.
    pub const SEAT_PITCH: Self = Self::new("seat_pitch");
}

/// Names and ids of the nodes, in the order of the plant's motors; the guard is last.
pub const NODES: [(NodeName, u8); 10] = [
    (NodeName::FRONT_LEFT_WHEEL, 2),
    (NodeName::FRONT_RIGHT_WHEEL, 3),
    (NodeName::REAR_LEFT_WHEEL, 4),
    (NodeName::REAR_RIGHT_WHEEL, 5),
    (NodeName::FRONT_STEERING, 6),
    (NodeName::REAR_STEERING, 7),
    (NodeName::FRONT_ROLL, 8),
    (NodeName::REAR_ROLL, 9),
    (NodeName::SEAT_PITCH, 10),
    (NodeName::GUARD, 1),
];

/// Returns the specification of every node: role, id, settings and motor.
pub fn nodes(robot: &RtMover, conditions: &Conditions) -> Vec<NodeSpec> {
    NODES
        .into_iter()
        .map(|(name, id)| {
            let drive = Drive::of(name);
            // The nodes send twenty-eight frames per SYNC period; with a period of 4 ms these would
            // take the whole bus.
            let mut settings = vec![(Setting::SyncPeriod, 5_000)];
            settings.extend(drive.map_or_else(|| guard(robot, conditions), Drive::settings));
            NodeSpec {
                name,
                role: drive.map_or(Role::Guard, |_| Role::Axle),
                id,
                settings,
                motor: None,
            }
            .with_motor(drive.map(Drive::motor))
        })
        .collect()
}

/// Kind of drive that a node moves.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Drive {
    Wheel,
    /// Steering shaft or pitch shaft.
    Shaft,
    /// Roll shaft, which carries half of the robot on a lever of 0.3 m.
    Roll,
}

// Gains: a velocity loop of bandwidth w needs the gain J w / T, where J is the inertia and T the
// torque per ampere, both at the output shaft.

/// Wheel: J = 0.036 (rotor) + 0.07 (a quarter of the robot) kg m^2, T = 2.4 N m/A, w = 100 rad/s.
/// The acceleration limit is low, so that a start is not mistaken for contact with a step.
const WHEEL: &[(Setting, i32)] = &[
    (Setting::VelocityLimit, 4_500),
    (Setting::AccelerationLimit, 5_000),
    (Setting::VelocityGain, 4_400),
    (Setting::PositionBits, 16),
];
/// Steering and pitch: J = 0.225 (rotor) + 0.4 (arm with wheels, or seat) kg m^2, T = 6 N m/A, w =
/// 60 rad/s.
const SHAFT: &[(Setting, i32)] = &[
    // A heavy load off the centre line moves arms and seat fast until their drives hold them.
    (Setting::VelocityLimit, 3_000),
    (Setting::VelocityGain, 6_200),
];
/// Roll: J = 0.9 (rotor) + 1.3 (half of the robot) kg m^2, T = 12 N m/A, w = 60 rad/s.
const ROLL: &[(Setting, i32)] = &[
    // The largest one with which a bridge that opens charges the supply to less than 36 V.
    (Setting::VelocityLimit, 1_690),
    (Setting::VelocityGain, 11_000),
];
/// Settings that steering, pitch and roll have in common.
const GEARED: &[(Setting, i32)] = &[
    (Setting::AccelerationLimit, 4_000),
    (Setting::PositionBits, 24),
    (Setting::HomingDirection, 1),
    (Setting::HomePosition, (SWITCH * 1e6) as i32),
    (Setting::HomingSpeed, 50),
    // The wheels stand still while their axle is steered, so homing needs the whole current and a
    // higher approach speed.
    (Setting::HomingCurrent, 10_000),
    (Setting::HomingApproach, 500),
];

impl Drive {
    fn of(name: NodeName) -> Option<Self> {
        match name {
            NodeName::FRONT_LEFT_WHEEL
            | NodeName::FRONT_RIGHT_WHEEL
            | NodeName::REAR_LEFT_WHEEL
            | NodeName::REAR_RIGHT_WHEEL => Some(Self::Wheel),
            NodeName::FRONT_STEERING | NodeName::REAR_STEERING | NodeName::SEAT_PITCH => {
                Some(Self::Shaft)
            }
            NodeName::FRONT_ROLL | NodeName::REAR_ROLL => Some(Self::Roll),
            _ => None,
        }
    }

    fn gear_milli(self) -> i32 {
        match self {
            Self::Wheel => 60_000,
            Self::Shaft => 150_000,
            Self::Roll => 300_000,
        }
    }

    fn settings(self) -> Vec<(Setting, i32)> {
        let mut values = Vec::from(match self {
            Self::Wheel => WHEEL,
            Self::Shaft => SHAFT,
            Self::Roll => ROLL,
        });
        if self != Self::Wheel {
            values.extend_from_slice(GEARED);
        }
        values
    }

    /// Returns the motor model. The paper does not specify the motors. These have
    /// three phases (stall torque at 10 A: wheel 24 N m, shaft 60 N m, roll 120 N m).
    fn motor(self) -> MotorModel {
        let friction_torque = if self == Self::Wheel { 0.3 } else { 1.0 };
        three_phase(self.gear_milli(), friction_torque)
    }
}

/// Margin levels for a robot that steps up with its centre of gravity 10 to 60 mm inside the
/// support of three wheels.
const LEVELS: &[(Setting, i32)] = &[
    (Setting::CautionMargin, 16_000),
    (Setting::StopMargin, 6_000),
    (Setting::TripMargin, 2_000),
    (Setting::BandHysteresis, 1_000),
];

fn guard(robot: &RtMover, conditions: &Conditions) -> Vec<(Setting, i32)> {
    let parameters = robot.parameters(conditions.friction);
    let mut values = vec![
        (Setting::FilterActive, i32::from(conditions.guard)),
        (
            Setting::RobotMass,
            (parameters.masses.total() * 1e3).round() as i32,
        ),
        (Setting::SpeedLimit, 300_000),
        (Setting::DriveAcceleration, 300_000),
    ];
    values.extend_from_slice(LEVELS);
    values.extend_from_slice(SENSORS);
    values.extend(robot.payload.iter().flat_map(Payload::settings));
    values
}
