//! Section `[motor.NODE]` of a scenario file: the motor of a node, where it differs from that of
//! the simulated robot.

use crate::bounds::{Problem, contradiction, within};
use serde::{Deserialize, Serialize};
use tautrack::link::{MotorModel, ThreePhaseModel, WindingModel};

/// Values of a motor that differ from those of the robot. They change the plant, and the node knows
/// them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motor {
    /// Kind of the motor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<Kind>,
    /// Resistance of the winding, or of one phase.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resistance_ohm: Option<f64>,
    /// Inductance of the winding, or of one phase in the axis d.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inductance_d_h: Option<f64>,
    /// Inductance of one phase in the axis q.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inductance_q_h: Option<f64>,
    /// Flux linkage of the magnets; for a brushed motor, its torque constant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flux_wb: Option<f64>,
    /// Pole pairs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pole_pairs: Option<u8>,
    /// Inertia at the rotor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotor_inertia_kgm2: Option<f64>,
    /// Coulomb friction at the output shaft.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_nm: Option<f64>,
    /// Amplitude of the cogging torque at the rotor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cogging_nm: Option<f64>,
    /// Periods of the cogging torque per turn of the rotor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cogging_periods: Option<u16>,
    /// Turns of the rotor per turn of the output shaft.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gear: Option<f64>,
}

/// Kind of a motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Brushed motor.
    Dc,
    /// Permanent-magnet motor with three phases.
    Pmsm,
}

/// Pole pairs of a three-phase motor in the place of a brushed one.
const POLE_PAIRS: u8 = 7;

impl Motor {
    /// Returns `model` with these values. Another kind keeps resistance, inductance and torque
    /// constant.
    #[must_use]
    pub fn apply(&self, model: &MotorModel) -> MotorModel {
        let of = |value: Option<f64>, known: f32| value.map_or(known, |value| value as f32);
        let kind = self.kind.unwrap_or(kind_of(model));
        let (resistance, inductance) = match model.winding {
            WindingModel::Brushed {
                resistance,
                inductance,
                ..
            } => (resistance, [inductance; 2]),
            WindingModel::ThreePhase(winding) => (winding.resistance, winding.inductance),
        };
        let resistance = of(self.resistance_ohm, resistance);
        let inductance_d = of(self.inductance_d_h, inductance[0]);
        let winding = match kind {
            Kind::Dc => WindingModel::Brushed {
                resistance,
                inductance: inductance_d,
                torque_constant: of(self.flux_wb, model.winding.torque_constant()),
            },
            Kind::Pmsm => {
                let known = match model.winding {
                    WindingModel::ThreePhase(winding) => winding,
                    WindingModel::Brushed { .. } => ThreePhaseModel {
                        resistance,
                        inductance,
                        flux: model.winding.torque_constant() / (1.5 * f32::from(POLE_PAIRS)),
                        pole_pairs: POLE_PAIRS,
                        offset_degrees: 0.0,
                        cogging_torque: 0.0,
                        cogging_periods: 6 * u16::from(POLE_PAIRS),
                    },
                };
                WindingModel::ThreePhase(ThreePhaseModel {
                    resistance,
                    inductance: [inductance_d, of(self.inductance_q_h, inductance[1])],
                    flux: of(self.flux_wb, known.flux),
                    pole_pairs: self.pole_pairs.unwrap_or(known.pole_pairs),
                    cogging_torque: of(self.cogging_nm, known.cogging_torque),
                    cogging_periods: self.cogging_periods.unwrap_or(known.cogging_periods),
                    ..known
                })
            }
        };
        MotorModel {
            winding,
            rotor_inertia: of(self.rotor_inertia_kgm2, model.rotor_inertia),
            friction_torque: of(self.friction_nm, model.friction_torque),
            gear_ratio: of(self.gear, model.gear_ratio),
            ..*model
        }
    }

    /// Checks the values, of the table `table` of a node with the motor `model`.
    ///
    /// # Errors
    /// [`Problem`] of the first bad value, with its key and bound.
    pub fn check(&self, table: &str, model: &MotorModel) -> Result<(), Problem> {
        let values = [
            ("resistance_ohm", self.resistance_ohm, 0.001, 100.0, "ohm"),
            ("inductance_d_h", self.inductance_d_h, 1e-6, 0.1, "H"),
            ("inductance_q_h", self.inductance_q_h, 1e-6, 0.1, "H"),
            ("flux_wb", self.flux_wb, 1e-5, 10.0, "Wb"),
            ("pole_pairs", self.pole_pairs.map(f64::from), 1.0, 64.0, ""),
            (
                "rotor_inertia_kgm2",
                self.rotor_inertia_kgm2,
                1e-8,
                1.0,
                "kg m^2",
            ),
            ("friction_nm", self.friction_nm, 0.0, 1_000.0, "N m"),
            ("cogging_nm", self.cogging_nm, 0.0, 10.0, "N m"),
            (
                "cogging_periods",
                self.cogging_periods.map(f64::from),
                1.0,
                4_096.0,
                "",
            ),
            ("gear", self.gear, 0.1, 2_000.0, ""),
        ];
        for (name, value, minimum, maximum, unit) in values {
            if let Some(value) = value {
                within(&format!("{table}.{name}"), value, minimum, maximum, unit)?;
            }
        }
        if self.kind.unwrap_or(kind_of(model)) == Kind::Dc {
            let of_three_phases = [
                ("inductance_q_h", self.inductance_q_h.is_some()),
                ("pole_pairs", self.pole_pairs.is_some()),
                ("cogging_nm", self.cogging_nm.is_some()),
                ("cogging_periods", self.cogging_periods.is_some()),
            ];
            for (name, given) in of_three_phases {
                if given {
                    let key = format!("{table}.{name}");
                    return contradiction(&key, "has no effect on a motor of the kind \"dc\"");
                }
            }
        }
        Ok(())
    }
}

fn kind_of(model: &MotorModel) -> Kind {
    match model.winding {
        WindingModel::Brushed { .. } => Kind::Dc,
        WindingModel::ThreePhase(_) => Kind::Pmsm,
    }
}
