//! Motors of the simulated robots, and the settings with which a node drives one of them.

use tautrack::link::{MotorModel, ThreePhaseModel, WindingModel};
use tautrack::motor::current::bandwidth_bound;
use tautrack::motor::model::POWER_STAGE;
use tautrack::settings::Setting;

/// Brushed motor of 24 V and 10 A with `torque_constant` N m/A, behind a gear of `gear_milli` /
/// 1000 rotor turns per turn of the output shaft, with the friction `friction_torque` N m at this
/// shaft.
pub const fn brushed(torque_constant: f32, gear_milli: i32, friction_torque: f32) -> MotorModel {
    MotorModel {
        winding: WindingModel::Brushed {
            resistance: 0.6,
            inductance: 0.3e-3,
            torque_constant,
        },
        rotor_inertia: 1e-5,
        gear_ratio: gear_milli as f32 * 1e-3,
        friction_torque,
        brake_torque: 0.0,
        encoder_counts: 4_096,
        current_noise: 0.02,
        current_quantum: 0.01,
        dead_time: 0.6e-6,
    }
}

/// Permanent-magnet motor with three phases and 0.04 N m/A; otherwise as [`brushed`]. Two of its
/// phases in series have the resistance of the brushed motor.
pub const fn three_phase(gear_milli: i32, friction_torque: f32) -> MotorModel {
    MotorModel {
        winding: WindingModel::ThreePhase(ThreePhaseModel {
            resistance: 0.3,
            inductance: [0.15e-3, 0.18e-3],
            flux: 0.04 / (1.5 * 7.0),
            pole_pairs: 7,
            offset_degrees: 40.0,
            cogging_torque: 0.0,
            cogging_periods: 42,
        }),
        ..brushed(0.0, gear_milli, friction_torque)
    }
}

/// Returns the settings of a node that knows its motor: those of the model, and a lower
/// [`Setting::CurrentBandwidth`] where the simulated power stage does not reach the default with
/// this winding.
pub fn settings(motor: &MotorModel) -> Vec<(Setting, i32)> {
    let scaled = |value: f32, scale: f64| (f64::from(value) * scale).round() as i32;
    let mut values = vec![
        (Setting::GearRatio, scaled(motor.gear_ratio, 1e3)),
        (Setting::EncoderCounts, motor.encoder_counts as i32),
        (
            Setting::TorqueConstant,
            scaled(motor.winding.torque_constant(), 1e6),
        ),
        (Setting::DeadTime, scaled(motor.dead_time, 1e9)),
    ];
    let (resistance, [inductance, inductance_q]) = match motor.winding {
        WindingModel::Brushed {
            resistance,
            inductance,
            ..
        } => (resistance, [inductance; 2]),
        WindingModel::ThreePhase(winding) => {
            values.extend([
                (Setting::MotorKind, 1),
                (Setting::InductanceQ, scaled(winding.inductance[1], 1e6)),
                (Setting::PolePairs, winding.pole_pairs.into()),
                (
                    Setting::ElectricalOffset,
                    scaled(winding.offset_degrees, 1e3),
                ),
            ]);
            (winding.resistance, winding.inductance)
        }
    };
    values.extend([
        (Setting::Resistance, scaled(resistance, 1e3)),
        (Setting::Inductance, scaled(inductance, 1e6)),
    ]);
    let larger = inductance.max(inductance_q);
    let largest = (0.9 * bandwidth_bound(resistance, larger, &POWER_STAGE)) as i32;
    let bandwidth = Setting::CurrentBandwidth.description();
    if largest < bandwidth.default {
        values.push((Setting::CurrentBandwidth, largest.max(bandwidth.minimum)));
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use tautrack::motor::current::{Config, CurrentLoop};
    use tautrack::settings::Settings;

    /// Resistances and inductances from those of a drone's motor to those of a small servo motor
    /// for mains voltage.
    #[test]
    fn a_node_accepts_the_settings_of_any_plausible_motor() {
        for kind in [brushed(0.04, 60_000, 0.5), three_phase(60_000, 0.5)] {
            for milliohm in [10, 100, 600, 3_000, 20_000] {
                for microhenry in [5, 50, 300, 1_600, 8_000, 20_000] {
                    let (resistance, inductance) =
                        (milliohm as f32 * 1e-3, microhenry as f32 * 1e-6);
                    let winding = match kind.winding {
                        WindingModel::Brushed {
                            torque_constant, ..
                        } => WindingModel::Brushed {
                            resistance,
                            inductance,
                            torque_constant,
                        },
                        WindingModel::ThreePhase(winding) => {
                            WindingModel::ThreePhase(ThreePhaseModel {
                                resistance,
                                inductance: [inductance, 1.6 * inductance],
                                ..winding
                            })
                        }
                    };
                    let mut known = Settings::default();
                    for (setting, value) in settings(&MotorModel { winding, ..kind }) {
                        known
                            .set(setting.description().key, value)
                            .expect("in range");
                    }
                    let config = Config::from_settings(&known, 20);
                    if let Err(error) = CurrentLoop::new(&config, &POWER_STAGE) {
                        panic!("{winding:?}: {error}");
                    }
                }
            }
        }
    }
}
