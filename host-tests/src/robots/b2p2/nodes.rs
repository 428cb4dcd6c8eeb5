//! B2P2's nodes: their ids, their settings and their motors.

use super::section::B2p2;
use crate::robots::motors::brushed;
use crate::robots::payload::Payload;
use crate::robots::section::SENSORS;
use crate::robots::{Conditions, NodeName, NodeSpec, Role};
use tautrack::link::MotorModel;
use tautrack::settings::Setting;

impl NodeName {
    /// Node of the chassis joint.
    pub const CHASSIS_JOINT: Self = Self::new("chassis_joint");
    /// Node of the driving screw.
    pub const SCREW: Self = Self::new("screw");
}

/// Names and ids of the nodes, in the order of the plant's motors; the guard is last.
pub const NODES: [(NodeName, u8); 5] = [
    (NodeName::LEFT_TRACK, 2),
    (NodeName::RIGHT_TRACK, 3),
    (NodeName::CHASSIS_JOINT, 4),
    (NodeName::SCREW, 5),
    (NodeName::GUARD, 1),
];

/// Returns the specification of every node: role, id, settings and motor.
pub fn nodes(robot: &B2p2, conditions: &Conditions) -> Vec<NodeSpec> {
    NODES
        .into_iter()
        .map(|(name, id)| {
            let node = NodeSpec {
                name,
                role: match name {
                    NodeName::SCREW => Role::Screw,
                    NodeName::GUARD => Role::Guard,
                    _ => Role::Axle,
                },
                id,
                settings: settings(name, robot, conditions),
                motor: None,
            };
            node.with_motor(motor(name))
        })
        .collect()
}

/// Returns the settings of a node that differ from the defaults.
fn settings(name: NodeName, robot: &B2p2, conditions: &Conditions) -> Vec<(Setting, i32)> {
    let micro = |metres: f64| (metres * 1e6).round() as i32;
    let mut values = vec![
        (Setting::PulleyRadius, micro(robot.pulley_radius_m)),
        (Setting::LengthK, micro(robot.k_m)),
    ];
    values.extend_from_slice(match name {
        NodeName::LEFT_TRACK | NodeName::RIGHT_TRACK => TRACK,
        NodeName::CHASSIS_JOINT => JOINT,
        NodeName::SCREW => SCREW,
        _ => SENSORS,
    });
    if name == NodeName::GUARD {
        values.push((Setting::FilterActive, i32::from(conditions.guard)));
        values.push((Setting::FeedForward, i32::from(conditions.feed_forward)));
        values.push((Setting::BodyHeight, micro(robot.com_offset_m)));
        values.extend(robot.payload.iter().flat_map(Payload::settings));
    }
    values
}

// Gains: a velocity loop of bandwidth w needs the gain J w / T, where J is the inertia and T the
// torque per ampere, both at the output shaft. The current loop is ten times faster than the
// fastest velocity loop.

/// Track: J = 0.036 (rotor) + 0.010 (half the robot's mass at the pulley) kg m^2, T = 2.4 N m/A, w
/// = 150 rad/s.
const TRACK: &[(Setting, i32)] = &[
    (Setting::VelocityLimit, 10_000),
    (Setting::AccelerationLimit, 20_000),
    (Setting::VelocityGain, 3_000),
    (Setting::PositionBits, 16),
];

/// Chassis joint: J = 0.225 (rotor) + 0.17 (front part) kg m^2, T = 6 N m/A, w = 150 rad/s.
const JOINT: &[(Setting, i32)] = &[
    (Setting::VelocityLimit, 2_500),
    (Setting::AccelerationLimit, 8_000),
    (Setting::VelocityGain, 10_000),
    (Setting::PositionGain, 20_000),
    (Setting::PositionBits, 32),
    (Setting::PositionMinimum, -1_040),
    (Setting::PositionMaximum, 1_740),
    (Setting::HomingDirection, 1),
    (Setting::HomePosition, 349_066),
    (Setting::HomingSpeed, 300),
];

/// Screw: J = 1.6e-4 kg m^2 (rotor; the nut adds a negligible amount), T = 0.16 N m/A, w = 300
/// rad/s.
const SCREW: &[(Setting, i32)] = &[
    (Setting::VelocityLimit, 140_000),
    (Setting::AccelerationLimit, 2_000_000),
    (Setting::VelocityGain, 300),
    (Setting::VelocityIntegralTime, 30_000),
    (Setting::PositionGain, 60_000),
    (Setting::FollowingLimit, 6_000),
    (Setting::HomingDirection, -1),
    (Setting::HomingSpeed, 25_000),
];

/// Returns the motor model of a node; `None` for the guard. The paper does not specify the motors.
/// These have the size that the robot's mass and speed require (24 V; stall torque at 10 A: track
/// 24 N m, joint 60 N m; screw 2 kN), all with the same rotor.
pub fn motor(name: NodeName) -> Option<MotorModel> {
    match name {
        NodeName::LEFT_TRACK | NodeName::RIGHT_TRACK => Some(brushed(0.04, 60_000, 0.3)),
        NodeName::CHASSIS_JOINT => Some(brushed(0.04, 150_000, 1.0)),
        NodeName::SCREW => Some(brushed(0.04, 4_000, 0.02)),
        _ => None,
    }
}
