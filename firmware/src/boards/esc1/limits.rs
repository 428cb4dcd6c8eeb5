//! Bounds and defaults of the settings that depend on what the board is built of.
//!
//! ST designed the board for batteries of up to six cells (UM2516), so for 25.2 V. It measures the
//! temperature between its transistors. Its gate drivers need a dead time: 300 ns are in use on
//! this board in other firmware. It has no output for a brake, and no input for the temperature of
//! the motor.

use super::analogue::ZERO;
use tautrack::motor::board_limits::Limit;
use tautrack::settings::Setting;

/// Highest supply voltage in a fault, V: that of the table in docs/motor.md. The transistors are
/// made for 60 V; nobody has looked at what the other parts bear.
pub const HIGHEST_SUPPLY: f32 = 36.0;

/// The bounds.
pub const LIMITS: [Limit; 11] = [
    limit(
        Setting::UnderVoltage,
        "under_voltage",
        [8_000, 24_000],
        12_000,
    ),
    limit(
        Setting::MotoringVoltage,
        "motoring_voltage",
        [8_000, 26_000],
        14_000,
    ),
    limit(
        Setting::RegenerationVoltage,
        "regeneration_voltage",
        [8_000, 26_000],
        23_000,
    ),
    limit(
        Setting::OverVoltage,
        "over_voltage",
        [12_000, 26_000],
        25_000,
    ),
    limit(Setting::DeadTime, "dead_time", [300, 600], 600),
    limit(
        Setting::CurrentZeroA,
        "current_zero_a",
        [16_384, 49_152],
        ZERO,
    ),
    limit(
        Setting::CurrentZeroB,
        "current_zero_b",
        [16_384, 49_152],
        ZERO,
    ),
    limit(
        Setting::BridgeTemperature,
        "bridge_temperature",
        [400, 1_000],
        800,
    ),
    limit(Setting::MotorTemperature, "motor_temperature", [0, 0], 0),
    limit(Setting::BrakeReleaseTime, "brake_release_time", [0, 0], 0),
    limit(Setting::BrakeEngageTime, "brake_engage_time", [0, 0], 0),
];

const fn limit(setting: Setting, name: &'static str, bounds: [i32; 2], default: i32) -> Limit {
    Limit {
        setting,
        name,
        bounds,
        default,
    }
}
