//! What the current control needs to know of supply and speed. The control task computes it once
//! per control period, in SI units, so that the PWM interrupt divides nothing.

use super::circle::Circle;
use super::{MIN_SUPPLY_VOLTAGE, VOLTAGE_FULL_SCALE};
use crate::math::{root_of_sum, sin_cos_q30, to_i32};
use crate::motor::bridge::{MAX_DUTY, Ratings};
use crate::units::Angle;

const ROOT_3: f32 = 1.732_050_8;

/// Parameters that do not change while the node runs.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Fixed {
    /// Of the power stage.
    pub ratings: Ratings,
    /// Electrical turns per turn of the output shaft, with the sign of the rotor's direction; 0 for
    /// a brushed motor.
    pub electrical_per_shaft: f32,
    /// Inductances of the axes d and q, henry.
    pub inductance: [f32; 2],
    /// Flux linkage of the magnets, V s.
    pub flux: f32,
    /// Amplitude of the back-EMF between two terminals, V s/rad of the output shaft.
    pub emf: f32,
    /// Resistance of the winding, or of one phase, ohm.
    pub resistance: f32,
    /// Current that bridge and winding carry for as long as it takes, A.
    pub continuous_current: f32,
}

/// Part of the continuous current that a short may take: when it begins, the current swings to
/// twice as much.
const SHORT: f32 = 0.7;
/// The same at which a short ends, because opening it then returns hardly any energy.
const SHORT_ENDS: f32 = 0.1;

impl Fixed {
    /// Returns whether a fault's reaction "brake" shorts the winding at this supply voltage, V, and
    /// velocity of the output shaft, rad/s, instead of opening the bridge. `shorted` is whether it
    /// does so already.
    ///
    /// An open bridge returns nothing while the back-EMF is below the supply. Above it, the diodes
    /// would charge the supply, so the winding is shorted if its current can flow for as long as it
    /// takes. A short that is opened while a current flows charges the supply, so it lasts until
    /// the motor is slow. NaN opens the bridge.
    pub(super) fn shorts(&self, supply_voltage: f32, shaft_velocity: f32, shorted: bool) -> bool {
        let short = self.short_current(shaft_velocity);
        if shorted {
            short > SHORT_ENDS * self.continuous_current
        } else {
            (self.emf * shaft_velocity).abs() > supply_voltage
                && short <= SHORT * self.continuous_current
        }
    }

    /// Returns the current of a shorted winding at this velocity of the output shaft, A.
    fn short_current(&self, shaft_velocity: f32) -> f32 {
        let speed = (self.electrical_per_shaft * shaft_velocity).abs();
        if speed == 0.0 {
            return (self.emf * shaft_velocity).abs() / self.resistance;
        }
        let [d, q] = self.inductance.map(|inductance| speed * inductance);
        let across = root_of_sum(q * q + self.resistance * self.resistance);
        speed * self.flux * across / (self.resistance * self.resistance + d * q)
    }
}

/// Supply voltage and speed, prepared for the PWM interrupt. 2^24 is [`VOLTAGE_FULL_SCALE`].
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct OperatingPoint {
    /// Largest voltage: of the winding of a brushed motor, or the length of the voltage vector. 0
    /// while the supply voltage is not known or too low.
    pub circle: Circle,
    /// Compare value of half the supply voltage.
    pub half: i32,
    /// Largest compare value, after the compensation of the dead time.
    pub highest: i32,
    /// Compare counts per full-scale voltage, times 2^12.
    pub counts_per_volt: i32,
    /// Cosine and sine of the electrical angle by which the rotor turns on until the middle of the
    /// period in which the voltage acts; 2^30 is one.
    pub lead: [i32; 2],
    /// Voltages by which currents in d and q couple into the other axis; 2^27 is one full-scale
    /// voltage per full-scale current.
    pub coupling: [i32; 2],
    /// Back-EMF.
    pub back_emf: i32,
}

impl OperatingPoint {
    /// Prepares the supply voltage, V, and the velocity of the output shaft, rad/s. Values that are
    /// not finite count as a supply that is off, and as standstill.
    pub fn new(fixed: &Fixed, supply_voltage: f32, shaft_velocity: f32) -> Self {
        let usable = supply_voltage >= MIN_SUPPLY_VOLTAGE && supply_voltage.is_finite();
        let period = f32::from(fixed.ratings.period);
        let three_phase = fixed.electrical_per_shaft != 0.0;
        let reach = if three_phase {
            MAX_DUTY / ROOT_3
        } else {
            MAX_DUTY
        };
        let volts = (1 << 24) as f32 / VOLTAGE_FULL_SCALE;
        let speed = shaft_velocity * fixed.electrical_per_shaft; // rad/s
        let coupling = |inductance: f32| {
            let per_ampere = speed * inductance * fixed.ratings.full_scale / VOLTAGE_FULL_SCALE;
            to_i32(per_ampere * (1 << 27) as f32)
        };
        // The voltage acts from the next period on, on average one and a half periods after the
        // sample.
        let lead = Angle::from_radians(1.5 * speed / fixed.ratings.pwm_hz as f32);
        let (sin, cos) = sin_cos_q30(lead);
        let emf = to_i32(speed * fixed.flux * volts);
        Self {
            circle: Circle::new(if usable {
                to_i32(supply_voltage * reach * volts)
            } else {
                0
            }),
            half: i32::from(fixed.ratings.period / 2),
            highest: i32::from(fixed.ratings.highest),
            counts_per_volt: if usable {
                to_i32(period / supply_voltage * (VOLTAGE_FULL_SCALE * 4096.0))
            } else {
                0
            },
            lead: [cos, sin],
            coupling: [coupling(fixed.inductance[0]), coupling(fixed.inductance[1])],
            back_emf: emf.clamp(-(1 << 25), 1 << 25),
        }
    }
}
