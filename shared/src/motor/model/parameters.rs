//! Parameters of a simulated motor, and the motion of its output shaft.

use serde::{Deserialize, Serialize};

/// A geared motor with its bridge and sensors. These values are the simulator's ground truth; the
/// firmware's settings may differ from them.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct MotorModel {
    /// Winding, with the magnets.
    pub winding: WindingModel,
    /// Inertia at the rotor, kg m^2.
    pub rotor_inertia: f32,
    /// Turns of the rotor per turn of the output shaft.
    pub gear_ratio: f32,
    /// Coulomb friction at the output shaft, N m.
    pub friction_torque: f32,
    /// Friction torque that a spring-applied brake adds while it is not released, N m; 0 without a
    /// brake.
    pub brake_torque: f32,
    /// Counts of the rotor sensor per turn of the rotor.
    pub encoder_counts: u32,
    /// Standard deviation of the current sensor's noise, A.
    pub current_noise: f32,
    /// Resolution of the current sensor's converter, A.
    pub current_quantum: f32,
    /// Time for which both transistors of a half bridge are off at each edge, s.
    pub dead_time: f32,
}

/// Winding of a motor.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub enum WindingModel {
    /// Brushed motor between half bridges a and b, with an incremental encoder.
    Brushed {
        /// Resistance, ohm.
        resistance: f32,
        /// Inductance, henry.
        inductance: f32,
        /// Torque constant, N m/A. It equals the back-EMF constant in V s/rad.
        torque_constant: f32,
    },
    /// Permanent-magnet motor with three phases.
    ThreePhase(ThreePhaseModel),
}

/// Winding of a permanent-magnet motor with three phases in star connection. Its rotor sensor is
/// absolute within a turn.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct ThreePhaseModel {
    /// Resistance of one phase, ohm.
    pub resistance: f32,
    /// Inductances of one phase in the axes d and q, henry.
    pub inductance: [f32; 2],
    /// Flux linkage of the magnets, V s. The torque constant is 1.5 times the pole pairs times it.
    pub flux: f32,
    /// Pole pairs, 1 to 64.
    pub pole_pairs: u8,
    /// Electrical angle where the rotor sensor reads 0, degrees.
    pub offset_degrees: f32,
    /// Amplitude of the cogging torque at the rotor, N m.
    pub cogging_torque: f32,
    /// Periods of the cogging torque per turn of the rotor.
    pub cogging_periods: u16,
}

impl WindingModel {
    /// Torque per current at the rotor, N m/A. The current of a three-phase motor is its amplitude.
    pub fn torque_constant(&self) -> f32 {
        match self {
            Self::Brushed {
                torque_constant, ..
            } => *torque_constant,
            Self::ThreePhase(model) => 1.5 * f32::from(model.pole_pairs) * model.flux,
        }
    }
}

/// Motion of the output shaft behind the gear. The load follows the shaft through a stiff coupling.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
pub struct Shaft {
    /// Position since power-up, 2^-32 turn.
    pub position: i64,
    /// Velocity, rad/s; always finite.
    pub velocity: f32,
}
