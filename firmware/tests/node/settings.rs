//! Model of a motor, and the settings of a node that drives it.

use tautrack::link::{MotorModel, WindingModel};
use tautrack::settings::Setting;

/// Motor model that suits all tests.
pub const MOTOR: MotorModel = MotorModel {
    winding: WindingModel::Brushed {
        resistance: 0.3,
        inductance: 2e-4,
        torque_constant: 0.05,
    },
    rotor_inertia: 1e-4,
    gear_ratio: 50.0,
    friction_torque: 1.0,
    brake_torque: 0.0,
    encoder_counts: 4096,
    current_noise: 0.02,
    current_quantum: 0.01,
    dead_time: 0.0,
};

/// Settings of node `node_id` that match [`MOTOR`].
pub fn settings(node_id: i32) -> Vec<(u16, i32)> {
    [
        (Setting::NodeId, node_id),
        (Setting::HeartbeatPeriod, 100),
        (Setting::GearRatio, 50_000),
        (Setting::EncoderCounts, 4_096),
        (Setting::TorqueConstant, 50_000),
        (Setting::Resistance, 300),
        (Setting::Inductance, 200),
        (Setting::CurrentLimit, 20_000),
        // 10 A s/rad times 2.5 N m/A over 0.25 kg m^2 gives a velocity loop of 100 rad/s, five
        // times the bandwidth of the position loop.
        (Setting::VelocityGain, 10_000),
    ]
    .map(|(setting, value)| (setting.description().key, value))
    .to_vec()
}
