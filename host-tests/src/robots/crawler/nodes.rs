//! The crawler's nodes, two axles and the guard: their ids, settings and motors.

use super::plant::CrawlerParameters;
use super::section::{Crawler, SlipCompensation};
use crate::robots::motors::brushed;
use crate::robots::payload::Payload;
use crate::robots::section::SENSORS;
use crate::robots::{Conditions, NodeName, NodeSpec, Role};
use tautrack::link::MotorModel;
use tautrack::settings::Setting;

/// Names and ids of the nodes, in the order of the plant's motors; the guard is last.
pub const NODES: [(NodeName, u8); 3] = [
    (NodeName::LEFT_TRACK, 2),
    (NodeName::RIGHT_TRACK, 3),
    (NodeName::GUARD, 1),
];

/// Returns the specification of every node: role, id, settings and motor.
pub fn nodes(robot: &Crawler, conditions: &Conditions) -> Vec<NodeSpec> {
    let p = robot.parameters(conditions.friction);
    NODES
        .into_iter()
        .map(|(name, id)| {
            let is_guard = name == NodeName::GUARD;
            NodeSpec {
                name,
                role: if is_guard { Role::Guard } else { Role::Axle },
                id,
                settings: if is_guard {
                    guard(robot, &p, conditions.guard)
                } else {
                    axle(robot, &p)
                },
                motor: None,
            }
            .with_motor((!is_guard).then(|| motor(&p)))
        })
        .collect()
}

fn micro(metres: f64) -> i32 {
    milli(metres * 1e3)
}

fn milli(value: f64) -> i32 {
    (value * 1e3).round() as i32
}

/// Maximum speed of a sprocket, mrad/s; it gives 0.56 m/s.
const SPROCKET_LIMIT: i32 = 20_000;

/// Settings of a track's axle. J = 0.051 (rotor) + 0.002 (half the robot's mass at the sprocket) kg
/// m^2, T = 1.07 N m/A, w = 150 rad/s (inertia, torque per ampere and bandwidth of the velocity
/// loop, whose gain is J w / T). The acceleration limit is twice the robot's acceleration, because
/// slip and curves require more of a sprocket.
fn axle(robot: &Crawler, p: &CrawlerParameters) -> Vec<(Setting, i32)> {
    let acceleration = 2.0 * robot.acceleration_mps2 / p.sprocket_radius;
    vec![
        (Setting::VelocityLimit, SPROCKET_LIMIT),
        (Setting::AccelerationLimit, milli(acceleration)),
        (Setting::VelocityGain, 7_400),
        (Setting::PositionBits, 16),
    ]
}

fn guard(robot: &Crawler, p: &CrawlerParameters, filters: bool) -> Vec<(Setting, i32)> {
    let soil = &robot.soil;
    let mut values = vec![
        (Setting::FilterActive, i32::from(filters)),
        (Setting::GearRatio, milli(p.gear_ratio)),
        (Setting::VelocityLimit, SPROCKET_LIMIT),
        (Setting::PulleyRadius, micro(p.sprocket_radius)),
        (Setting::TrackGauge, micro(p.track_spacing)),
        (Setting::ContactLength, micro(p.contact_length)),
        (Setting::TrackWidth, micro(p.track_width)),
        (Setting::RobotMass, milli(p.mass)),
        (Setting::CogHeight, micro(p.cog[2])),
        (Setting::SoilCohesion, soil.cohesion_pa.round() as i32),
        (
            Setting::SoilFrictionAngle,
            milli(soil.friction_deg.to_radians()),
        ),
        (Setting::SoilK1, milli(soil.k1_per_m)),
        (Setting::SoilK2, milli(soil.k2)),
        (
            Setting::SlipCompensation,
            match robot.slip_compensation {
                SlipCompensation::None => 0,
                SlipCompensation::Soil => 1,
                SlipCompensation::Measured => 2,
            },
        ),
        (Setting::DriveAcceleration, micro(robot.acceleration_mps2)),
    ];
    values.extend_from_slice(LEVELS);
    values.extend_from_slice(SENSORS);
    values.extend(robot.payload.iter().flat_map(Payload::settings));
    values
}

/// Margin levels for a robot whose tracks are 127 mm long and 145 mm apart.
const LEVELS: &[(Setting, i32)] = &[
    (Setting::CautionMargin, 30_000),
    (Setting::StopMargin, 20_000),
    (Setting::TripMargin, 5_000),
    (Setting::BandHysteresis, 3_000),
];

/// Motor model of an axle. The paper does not specify the motors. This is B2P2's motor, wound for
/// the speed that the paper's gear requires (22 rad/s of a sprocket at 24 V without load).
fn motor(p: &CrawlerParameters) -> MotorModel {
    brushed(0.015, milli(p.gear_ratio), 0.1)
}
