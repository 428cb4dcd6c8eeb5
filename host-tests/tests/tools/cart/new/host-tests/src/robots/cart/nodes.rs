//! The cart's nodes: two axles and the guard.

use super::section::Cart;
use crate::robots::motors::brushed;
use crate::robots::section::SENSORS;
use crate::robots::{Conditions, NodeName, NodeSpec, Role};
use tautrack::link::MotorModel;
use tautrack::robots::cart::parameters::CART;
use tautrack::settings::Setting;

/// Names and ids of the nodes: those of the plant's motors in their order, then the guard.
pub const NODES: [(NodeName, u8); 3] = [
    (NodeName::new("left_wheel"), 2),
    (NodeName::new("right_wheel"), 3),
    (NodeName::GUARD, 1),
];

/// Settings and motor of each node.
pub fn nodes(robot: &Cart, conditions: &Conditions) -> Vec<NodeSpec> {
    NODES
        .into_iter()
        .map(|(name, id)| {
            let is_guard = name == NodeName::GUARD;
            NodeSpec {
                name,
                role: if is_guard { Role::Guard } else { Role::Axle },
                id,
                settings: if is_guard {
                    guard(robot, conditions.guard)
                } else {
                    axle(robot)
                },
                motor: None,
            }
            .with_motor((!is_guard).then_some(MOTOR))
        })
        .collect()
}

fn milli(value: f64) -> i32 {
    (value * 1e3).round() as i32
}

fn micro(metres: f64) -> i32 {
    milli(metres * 1e3)
}

/// Settings of an axle: J = 0.016 (rotor) + 0.027 (half of the cart) kg m^2, T = 1.6 N m/A, w = 150
/// rad/s. The acceleration is doubled, because on a curve a wheel accelerates more than the cart.
fn axle(robot: &Cart) -> Vec<(Setting, i32)> {
    let acceleration = 2.0 * robot.acceleration_mps2 / CART.wheel_radius;
    vec![
        (Setting::VelocityLimit, 10_000),
        (Setting::AccelerationLimit, milli(acceleration)),
        (Setting::VelocityGain, 4_000),
        (Setting::PositionBits, 16),
    ]
}

fn guard(robot: &Cart, filters: bool) -> Vec<(Setting, i32)> {
    let [_, up] = CART.cog(robot.mast_m);
    let mut values = vec![
        (Setting::FilterActive, i32::from(filters)),
        (Setting::PulleyRadius, micro(CART.wheel_radius)),
        (Setting::TrackGauge, micro(CART.gauge)),
        (Setting::RobotMass, milli(CART.mass())),
        (Setting::CogHeight, micro(up)),
        (Setting::DriveAcceleration, micro(robot.acceleration_mps2)),
    ];
    values.extend_from_slice(LEVELS);
    values.extend_from_slice(SENSORS);
    values
}

/// Margins of a cart whose centre of gravity is 88 mm behind the axle.
const LEVELS: &[(Setting, i32)] = &[
    (Setting::CautionMargin, 40_000),
    (Setting::StopMargin, 12_000),
    (Setting::TripMargin, 4_000),
    (Setting::BandHysteresis, 2_000),
];

/// B2P2's motor with another gear.
const MOTOR: MotorModel = brushed(0.04, 40_000, 0.1);
