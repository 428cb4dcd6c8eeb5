//! Electrical part of a motor: bridge and winding.
//!
//! A half bridge has its mean voltage for the whole period, so the current has no ripple within it.
//! A board samples the current in the middle of the zero vector. That is the mean only if the time
//! constant of the winding is long: with an inductance of some uH the sample is near 0 on a board,
//! and here it is not.

use super::{ThreePhaseModel, WindingModel, bounded, magnitude};
use crate::math::trig::sin_cos;
use crate::motor::bridge::{PowerStage, Ratings};
use crate::units::Angle;

const HALF_ROOT_3: f32 = 0.866_025_4;
const TWO_BY_ROOT_3: f32 = 1.154_700_5;
/// Current within which the dead time acts only partly, because the current changes its direction
/// within a PWM period, A.
const CROSSING: f32 = 0.1;

/// Supply of the bridge.
#[derive(Clone, Debug)]
pub(super) struct Supply {
    voltage: f32,
    /// V per compare count.
    per_count: f32,
    /// V that the dead time takes from a half bridge, and its slope at a current of zero.
    dead: f32,
    dead_slope: f32,
    /// Part of the supply voltage per compare count, and part of the period that is dead.
    share: f32,
    dead_share: f32,
}

impl Supply {
    /// Creates a supply of 0 V. The dead time is in s.
    pub fn new(ratings: &Ratings, dead_time: f32) -> Self {
        Self {
            voltage: 0.0,
            per_count: 0.0,
            dead: 0.0,
            dead_slope: 0.0,
            share: 1.0 / f32::from(ratings.period),
            dead_share: dead_time * ratings.pwm_hz as f32,
        }
    }

    /// Sets the voltage, V.
    pub fn set(&mut self, voltage: f32) {
        self.voltage = voltage;
        self.per_count = voltage * self.share;
        self.dead = voltage * self.dead_share;
        self.dead_slope = self.dead / CROSSING;
    }

    /// Mean voltage of a half bridge over one period. During the dead time a diode conducts, which
    /// opposes the current.
    fn half_bridge(&self, compare: u16, current: f32) -> f32 {
        let lost = if magnitude(current) > magnitude(CROSSING) {
            self.dead.copysign(current)
        } else {
            self.dead_slope * current
        };
        f32::from(compare) * self.per_count - lost
    }
}

/// State of a winding, with the currents out of the bridge.
#[derive(Clone, Debug)]
pub(super) enum Winding {
    Brushed(Brushed),
    ThreePhase(ThreePhase),
}

/// Winding of a brushed motor.
#[derive(Clone, Debug)]
pub(super) struct Brushed {
    torque_constant: f32,
    /// Period divided by the inductance, A/V.
    rise: f32,
    damping: f32, // 1 + rise times resistance
    current: f32, // A
}

/// Winding of a permanent-magnet motor, in the rotor's axes.
#[derive(Clone, Debug)]
pub(super) struct ThreePhase {
    model: ThreePhaseModel,
    pole_pairs: f32,
    offset: Angle,
    rise: [f32; 2],
    damping: [f32; 2],
    dq: [f32; 2], // A
    /// Sine and cosine of the electrical angle.
    axes: Axes,
    /// Currents out of the half bridges with these `dq` and `axes`, A.
    phases: [f32; 3],
}

impl Winding {
    /// Creates a winding without current. Returns `None` unless its values are finite and positive.
    pub fn new(model: WindingModel, period: f32) -> Option<Self> {
        let positive =
            |values: &[f32]| values.iter().all(|value| value.is_finite() && *value > 0.0);
        match model {
            WindingModel::Brushed {
                resistance,
                inductance,
                torque_constant,
            } => positive(&[resistance, inductance, torque_constant]).then(|| {
                let rise = period / inductance;
                Self::Brushed(Brushed {
                    torque_constant,
                    rise,
                    damping: 1.0 + rise * resistance,
                    current: 0.0,
                })
            }),
            WindingModel::ThreePhase(model) => {
                let [d, q] = model.inductance;
                let good = positive(&[model.resistance, d, q, model.flux])
                    && model.cogging_torque.is_finite()
                    && (1..=64).contains(&model.pole_pairs);
                let rise = [period / d, period / q];
                good.then(|| {
                    Self::ThreePhase(ThreePhase {
                        pole_pairs: model.pole_pairs as f32,
                        offset: Angle::from_degrees(model.offset_degrees),
                        rise,
                        damping: rise.map(|rise| 1.0 + rise * model.resistance),
                        dq: [0.0; 2],
                        axes: (0.0, 1.0),
                        phases: [0.0; 3],
                        model,
                    })
                })
            }
        }
    }

    /// Integrates one period. Returns the torque on the rotor, N m.
    pub fn integrate(&mut self, stage: PowerStage, supply: &Supply, velocity: f32) -> f32 {
        match self {
            Self::Brushed(winding) => winding.integrate(stage, supply, velocity),
            Self::ThreePhase(winding) => winding.integrate(stage, supply, velocity),
        }
    }

    /// Turns the rotor's axes to this angle of the rotor. The last act of each period.
    pub fn turn_to(&mut self, rotor: Angle) {
        if let Self::ThreePhase(winding) = self {
            winding.axes = sin_cos(winding.electrical(rotor));
            winding.phases = phases(winding.dq, winding.axes);
        }
    }

    /// Electrical angle at this angle of the rotor; 0 of a brushed motor.
    pub fn electrical(&self, rotor: Angle) -> Angle {
        match self {
            Self::Brushed(_) => Angle::ZERO,
            Self::ThreePhase(winding) => winding.electrical(rotor),
        }
    }

    /// Ends the current of the lead 0 (a), 1 (b) or 2 (c), which is open. The terminal takes the
    /// voltage at which no current flows.
    #[cold]
    pub fn open_lead(&mut self, lead: usize) {
        match self {
            Self::Brushed(winding) => {
                if lead < 2 {
                    winding.current = 0.0;
                }
            }
            Self::ThreePhase(winding) => {
                // Axis of the phase in the rotor's axes: the currents d and q of 1 A in alpha and
                // beta of this phase.
                let (sin, cos) = winding.axes;
                let (alpha, beta) = match lead {
                    0 => (1.0, 0.0),
                    1 => (-0.5, HALF_ROOT_3),
                    _ => (-0.5, -HALF_ROOT_3),
                };
                let axis = [alpha * cos + beta * sin, beta * cos - alpha * sin];
                let along = winding.dq[0] * axis[0] + winding.dq[1] * axis[1];
                winding.dq = [
                    winding.dq[0] - along * axis[0],
                    winding.dq[1] - along * axis[1],
                ];
            }
        }
    }

    /// Currents out of half bridges a and b, A.
    pub fn phase_currents(&self) -> [f32; 2] {
        match self {
            Self::Brushed(winding) => [winding.current, -winding.current],
            Self::ThreePhase(winding) => [winding.phases[0], winding.phases[1]],
        }
    }
}

impl Brushed {
    fn integrate(&mut self, stage: PowerStage, supply: &Supply, velocity: f32) -> f32 {
        let emf = self.torque_constant * velocity;
        self.current = match stage {
            PowerStage::Drive([a, b, _]) => {
                let voltage =
                    supply.half_bridge(a, self.current) - supply.half_bridge(b, -self.current);
                self.after(voltage - emf)
            }
            PowerStage::Brake => self.after(-emf),
            PowerStage::Off => self.through_diodes(supply.voltage, emf),
        };
        self.torque_constant * self.current
    }

    /// Current after one period with `voltage` on resistance and inductance alone (backward Euler).
    fn after(&self, voltage: f32) -> f32 {
        bounded((self.current + self.rise * voltage) / self.damping)
    }

    /// Current after one period with all transistors open. The diodes put the whole supply voltage
    /// against the current until it is zero. If no current flows, they conduct only where the
    /// back-EMF exceeds the supply.
    #[cold]
    fn through_diodes(&self, supply: f32, emf: f32) -> f32 {
        let forward = if self.current == 0.0 {
            emf < 0.0
        } else {
            self.current > 0.0
        };
        let clamp = if forward { -supply } else { supply };
        let current = self.after(clamp - emf);
        if (current > 0.0) == forward {
            current
        } else {
            0.0
        }
    }
}

/// Sine and cosine of the electrical angle.
type Axes = (f32, f32);

/// Currents of the three phases for currents in the rotor's axes.
fn phases([d, q]: [f32; 2], (sin, cos): Axes) -> [f32; 3] {
    let (alpha, beta) = (d * cos - q * sin, d * sin + q * cos);
    let across = HALF_ROOT_3 * beta;
    [alpha, -0.5 * alpha + across, -0.5 * alpha - across]
}

impl ThreePhase {
    fn electrical(&self, rotor: Angle) -> Angle {
        let turned = rotor.to_bits().wrapping_mul(self.model.pole_pairs.into());
        Angle::from_bits(turned) + self.offset
    }

    /// Voltage in the rotor's axes for the voltages of the three half bridges.
    fn voltage([a, b, c]: [f32; 3], (sin, cos): Axes) -> [f32; 2] {
        let alpha = (a - 0.5 * (b + c)) * (2.0 / 3.0);
        let beta = (b - c) * (0.5 * TWO_BY_ROOT_3);
        [alpha * cos + beta * sin, beta * cos - alpha * sin]
    }

    fn integrate(&mut self, stage: PowerStage, supply: &Supply, velocity: f32) -> f32 {
        let (speed, axes) = (self.pole_pairs * velocity, self.axes);
        self.dq = match stage {
            PowerStage::Drive(compare) => {
                let volts = core::array::from_fn(|phase| {
                    supply.half_bridge(compare[phase], self.phases[phase])
                });
                self.after(Self::voltage(volts, axes), speed)
            }
            PowerStage::Brake => self.after([0.0; 2], speed),
            PowerStage::Off => self.through_diodes(supply.voltage, speed),
        };
        let ([d, q], [inductance_d, inductance_q]) = (self.dq, self.model.inductance);
        1.5 * self.pole_pairs * (self.model.flux + (inductance_d - inductance_q) * d) * q
    }

    /// Currents after one period with `voltage` at the winding, implicit in the resistance.
    fn after(&self, voltage: [f32; 2], speed: f32) -> [f32; 2] {
        let ([d, q], [inductance_d, inductance_q]) = (self.dq, self.model.inductance);
        let induced = [
            speed * inductance_q * q,
            -speed * (inductance_d * d + self.model.flux),
        ];
        core::array::from_fn(|axis| {
            let driven = self.dq[axis] + self.rise[axis] * (voltage[axis] + induced[axis]);
            bounded(driven / self.damping[axis])
        })
    }

    /// Currents after one period with all transistors open. The diode of each phase puts half of
    /// the supply voltage against its current, until the currents reach zero. If no current flows,
    /// the diodes conduct only where the back-EMF between two phases exceeds the supply.
    #[cold]
    fn through_diodes(&self, supply: f32, speed: f32) -> [f32; 2] {
        let ([d, q], axes) = (self.dq, self.axes);
        let emf = speed * self.model.flux;
        let flows = d != 0.0 || q != 0.0;
        let direction = if flows {
            self.phases
        } else {
            phases([0.0, -emf], axes) // the current that the back-EMF drives
        };
        // The line-to-line amplitude is the root of three times that of a phase.
        if !flows && 2.0 * HALF_ROOT_3 * emf.abs() <= supply {
            return [0.0; 2];
        }
        let volts = direction.map(|current| {
            let half = 0.5 * supply;
            if current > 0.0 {
                -half
            } else if current < 0.0 {
                half
            } else {
                0.0
            }
        });
        let [next_d, next_q] = self.after(Self::voltage(volts, axes), speed);
        // The current never reverses: beyond zero, the diodes block.
        if flows && next_d * d + next_q * q <= 0.0 {
            return [0.0; 2];
        }
        [next_d, next_q]
    }
}
