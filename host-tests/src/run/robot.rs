//! B2P2's nodes: their ids, what each is told about itself, and what motor it has.

use crate::scenario::{NodeName, Scenario};
use heapless::Vec;
use tautrack::link::{MAX_SETTINGS, MotorModel};
use tautrack::settings::Setting;

/// The node's id on the bus.
pub fn node_id(name: NodeName) -> u8 {
    match name {
        NodeName::Guard => 1,
        NodeName::LeftTrack => 2,
        NodeName::RightTrack => 3,
        NodeName::ChassisJoint => 4,
        NodeName::Screw => 5,
    }
}

/// The name of the node with this id.
pub fn node_name(id: u8) -> Option<NodeName> {
    NodeName::ALL.into_iter().find(|name| node_id(*name) == id)
}

/// Settings of a node, as key and value. What a robot does not change stays at the table's default.
pub fn settings(name: NodeName, scenario: &Scenario) -> Vec<(u16, i32), MAX_SETTINGS> {
    let micro = |metres: f64| (metres * 1e6).round() as i32;
    let robot = &scenario.robot;
    let mut values = vec![
        (Setting::NodeId, i32::from(node_id(name))),
        (Setting::PulleyRadius, micro(robot.pulley_radius_m)),
        (Setting::LengthK, micro(robot.k_m)),
    ];
    if let Some(gear) = gear_milli(name) {
        values.push((Setting::GearRatio, gear));
    }
    values.extend_from_slice(match name {
        NodeName::LeftTrack | NodeName::RightTrack => TRACK,
        NodeName::ChassisJoint => JOINT,
        NodeName::Screw => SCREW,
        NodeName::Guard => GUARD,
    });
    if name == NodeName::Guard {
        values.push((Setting::FilterActive, i32::from(scenario.guard)));
        values.push((Setting::BodyHeight, micro(robot.com_offset_m)));
        if let Some(payload) = robot.payload.as_ref().filter(|payload| payload.declared) {
            let [forward, left, up] = payload.place_m.map(micro);
            values.extend([
                (Setting::PayloadMass, (payload.mass_kg * 1e3).round() as i32),
                (Setting::PayloadForward, forward),
                (Setting::PayloadLeft, left),
                (Setting::PayloadUp, up),
            ]);
        }
    }
    values
        .into_iter()
        .map(|(setting, value)| (setting.description().key, value))
        .collect()
}

// Gains: with the inertia J at the output shaft and the torque T per ampere there, a velocity loop of bandwidth w needs
// J w / T. The current loop is ten times faster than the fastest of them.

/// J = 0.036 (rotor) + 0.010 (half the robot's mass at the pulley) kg m^2, T = 2.4 N m/A, w = 150 rad/s.
const TRACK: &[(Setting, i32)] = &[
    (Setting::VelocityLimit, 10_000),
    (Setting::AccelerationLimit, 20_000),
    (Setting::VelocityGain, 3_000),
    (Setting::PositionBits, 16),
];

/// J = 0.225 (rotor) + 0.17 (front part) kg m^2, T = 6 N m/A, w = 150 rad/s.
const JOINT: &[(Setting, i32)] = &[
    (Setting::VelocityLimit, 2_500),
    (Setting::AccelerationLimit, 8_000),
    (Setting::VelocityGain, 10_000),
    (Setting::PositionGain, 20_000),
    (Setting::PositionBits, 32),
    (Setting::PositionMinimum, -1_040),
    (Setting::PositionMaximum, 1_740),
    (Setting::ReferenceDirection, 1),
    (Setting::ReferencePosition, 349_066),
    (Setting::ReferenceSpeed, 300),
];

/// J = 1.6e-4 kg m^2 (rotor; the nut adds next to nothing), T = 0.16 N m/A, w = 300 rad/s.
const SCREW: &[(Setting, i32)] = &[
    (Setting::VelocityLimit, 140_000),
    (Setting::AccelerationLimit, 2_000_000),
    (Setting::VelocityGain, 300),
    (Setting::VelocityIntegralTime, 30_000),
    (Setting::PositionGain, 60_000),
    (Setting::FollowingLimit, 6_000),
    (Setting::ReferenceDirection, -1),
    (Setting::ReferenceSpeed, 25_000),
];

/// What a calibration left of the plant's declination and hard iron: off by up to 0.4 uT.
const GUARD: &[(Setting, i32)] = &[
    (Setting::Declination, 1_000),
    (Setting::HardIronForward, 8_300),
    (Setting::HardIronLeft, -4_800),
    (Setting::HardIronUp, 12_400),
];

/// Rotor turns per thousand turns of the output shaft; `None` for the guard.
fn gear_milli(name: NodeName) -> Option<i32> {
    match name {
        NodeName::LeftTrack | NodeName::RightTrack => Some(60_000),
        NodeName::ChassisJoint => Some(150_000),
        NodeName::Screw => Some(4_000),
        NodeName::Guard => None,
    }
}

/// The motor of a node. The paper names no motors: these are of the size that the robot's mass and speed ask for (24 V,
/// stall torque at 10 A: track 24 N m, joint 60 N m; screw 2 kN), all with the same rotor.
pub fn motor(name: NodeName) -> Option<MotorModel> {
    let gear = gear_milli(name)?;
    Some(MotorModel {
        resistance: 0.6,
        inductance: 0.3e-3,
        torque_constant: 0.04,
        rotor_inertia: 1e-5,
        gear_ratio: gear as f32 * 1e-3,
        friction_torque: match name {
            NodeName::ChassisJoint => 1.0,
            NodeName::Screw => 0.02,
            _ => 0.3,
        },
        encoder_counts: 4_096,
        current_noise: 0.02,
        current_quantum: 0.01,
    })
}
