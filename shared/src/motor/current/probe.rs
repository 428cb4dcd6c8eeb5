//! Excites a motor with voltages instead of controlling its current, and sums what it measures.
//! The calibration uses it.
//!
//! A voltage has two components in a frame, d and q. The frame stands, turns at a given speed, or
//! turns with the rotor. A brushed motor has the component d alone. On the voltage comes a ripple:
//! a square wave that is synchronous with the PWM.

use super::foc::park;
use super::operating_point::OperatingPoint;
use super::{Motor, VOLTAGE_FULL_SCALE};
use crate::math::cubic::mul_high_add;
use crate::math::{sin_cos_q30, sqrt, to_i32};
use crate::motor::bridge::{CurrentSensing, Ratings, Readings};
use crate::motor::rotor::Rotor;
use crate::units::Angle;
use core::num::NonZeroU32;

/// Axes to which the voltage refers.
#[derive(Clone, Copy, Debug)]
pub enum Frame {
    /// Stands at `angle` when the excitation is set, and turns by `step` per PWM period.
    Stator {
        /// Electrical angle of the axis d.
        angle: Angle,
        /// Electrical angle per PWM period.
        step: Angle,
    },
    /// Turns with the rotor.
    Rotor {
        /// Angle from the rotor sensor.
        rotor: Rotor,
        /// Angle by which the rotor turns until the voltage acts.
        lead: Angle,
    },
}

/// What the bridge does until the next excitation.
#[derive(Clone, Copy, Debug)]
pub struct Excitation {
    /// Axes of the voltage.
    pub frame: Frame,
    /// Voltage in d and q, V.
    pub voltage: [f32; 2],
    /// Amplitude of the ripple in d and q, V.
    pub ripple: [f32; 2],
    /// PWM periods of half a ripple period.
    pub half_period: NonZeroU32,
    /// Offset and gain with which the currents are measured.
    pub sensing: CurrentSensing,
    /// The bridge is open, and only the codes are measured.
    pub open: bool,
}

impl Default for Excitation {
    /// Zero voltage: all half bridges give half of the supply voltage.
    fn default() -> Self {
        Self {
            frame: Frame::Stator {
                angle: Angle::ZERO,
                step: Angle::ZERO,
            },
            voltage: [0.0; 2],
            ripple: [0.0; 2],
            half_period: NonZeroU32::MIN,
            sensing: CurrentSensing::default(),
            open: false,
        }
    }
}

/// Means since the previous measurement.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Measurement {
    /// Codes of the current converter.
    pub codes: [f32; 2],
    /// Current in d and q, A.
    pub current: [f32; 2],
    /// Voltage in d and q that the compare values meant, V.
    pub voltage: [f32; 2],
    /// Half of the peak-to-peak current that the ripple causes in d and q, A.
    pub response: [f32; 2],
    /// Number of samples in `response`.
    pub responses: u32,
    /// Angle of the frame at the last sample.
    pub angle: Angle,
    /// Count of the rotor sensor at the last sample.
    pub rotor: u32,
    /// Count of the rotor sensor at the newest pulse of an encoder's index.
    pub index: Option<u32>,
}

/// Fraction bits of a compare count in the sum of the voltages.
const COUNT_BITS: u32 = 10;
/// Periods from the computation of a voltage to the sample at its end.
const DELAY: u32 = 2;

/// State of the excitation in the PWM interrupt.
#[derive(Clone, Debug, Default)]
pub(super) struct Probe {
    excitation: Excitation,
    /// 2^24 is the full scale.
    voltage: [i32; 2],
    ripple: [i32; 2],
    angle: Angle,
    /// Periods since the present half of the ripple began, and its sign.
    since: u32,
    sign: i32,
    sums: Sums,
}

#[derive(Clone, Debug, Default)]
struct Sums {
    samples: u32,
    codes: [u32; 2],
    current: [i64; 2],
    voltage: [i64; 2],
    responses: u32,
    response: [i64; 2],
    angle: Angle,
    rotor: u32,
}

impl Probe {
    /// Sets the excitation. A voltage that is longer than the bridge can give in every direction is
    /// shortened. NaN counts as 0 V.
    pub fn excite(&mut self, excitation: &Excitation, point: &OperatingPoint) {
        let volts = (1 << 24) as f32 / VOLTAGE_FULL_SCALE;
        let longest =
            [0, 1].map(|axis| excitation.voltage[axis].abs() + excitation.ripple[axis].abs());
        let length = sqrt(longest[0] * longest[0] + longest[1] * longest[1]) * volts;
        let limit = point.circle.radius() as f32;
        let scale = if length <= limit {
            volts
        } else {
            volts * limit / length
        };
        self.voltage = excitation.voltage.map(|value| to_i32(value * scale));
        self.ripple = excitation.ripple.map(|value| to_i32(value * scale));
        if let Frame::Stator { angle, .. } = excitation.frame {
            self.angle = angle;
        }
        if self.sign == 0 {
            self.sign = 1;
        }
        if self.since >= excitation.half_period.get() {
            self.since = 0;
        }
        self.excitation = *excitation;
    }

    /// Clears the sums and returns the means; `None` if no sample was taken.
    pub fn take(&mut self, ratings: &Ratings, supply_voltage: f32) -> Option<Measurement> {
        let sums = core::mem::take(&mut self.sums);
        if sums.samples == 0 {
            return None;
        }
        let samples = sums.samples as f32;
        let responses = if sums.responses == 0 {
            1
        } else {
            sums.responses
        };
        let ampere = ratings.full_scale / (1 << 26) as f32;
        let volt = supply_voltage / f32::from(ratings.period) / (1 << COUNT_BITS) as f32;
        Some(Measurement {
            codes: sums.codes.map(|sum| sum as f32 / samples),
            current: sums.current.map(|sum| sum as f32 * ampere / samples),
            voltage: sums.voltage.map(|sum| sum as f32 * volt / samples),
            response: sums
                .response
                .map(|sum| sum as f32 * ampere / responses as f32),
            responses: sums.responses,
            angle: sums.angle,
            rotor: sums.rotor,
            index: None,
        })
    }

    /// Sums the codes of a period in which the bridge is open.
    pub fn listen(&mut self, readings: &Readings) {
        let sums = &mut self.sums;
        sums.samples += 1;
        sums.rotor = readings.rotor;
        for (sum, code) in sums.codes.iter_mut().zip(readings.currents) {
            *sum += u32::from(code);
        }
    }

    /// Runs one period: computes the compare values. 2^30 is the full scale of the currents.
    pub fn step(
        &mut self,
        motor: &Motor,
        readings: Readings,
        currents: [i32; 2],
        point: &OperatingPoint,
    ) -> [u16; 3] {
        let (angle, lead) = match &self.excitation.frame {
            Frame::Stator { step, .. } => {
                self.angle += *step;
                (self.angle, Angle::ZERO)
            }
            Frame::Rotor { rotor, lead } => (rotor.angle(readings.rotor).0, *lead),
        };
        let [d, q] = [0, 1].map(|axis| self.voltage[axis] + self.sign * self.ripple[axis]);
        let (current, compare, voltage) = match motor {
            Motor::Brushed(_) => {
                let part =
                    |voltage| mul_high_add(point.half, voltage, point.counts_per_volt >> 5) as u16;
                let (a, b) = (part(d), part(-d));
                let voltage = [(i32::from(a) - i32::from(b)) << COUNT_BITS, 0];
                ([currents[0] >> 4, 0], [a, b, point.half as u16], voltage)
            }
            Motor::ThreePhase(foc, ..) => {
                let axes = sin_cos_q30(angle);
                let ahead = sin_cos_q30(angle + lead);
                let compare = foc.open_loop([d, q], ahead, point);
                // The transform of the currents divides by 2^4.
                let [a, b, c] = compare.map(|count| (i32::from(count) << (COUNT_BITS + 4)) / 3);
                let voltage = park([a + a - b - c, b + b - a - c], ahead);
                (park(currents, axes), compare, voltage)
            }
        };
        self.sum(readings, current, voltage, angle);
        compare
    }

    fn sum(&mut self, readings: Readings, current: [i32; 2], voltage: [i32; 2], angle: Angle) {
        let sums = &mut self.sums;
        sums.samples += 1;
        (sums.angle, sums.rotor) = (angle, readings.rotor);
        // The sample at the end of a half of the ripple comes in the next half, if it is short.
        let half = self.excitation.half_period;
        let since_end = half.get() + DELAY - 1 - self.since;
        let ended = since_end % half == 0;
        let halves_ago = since_end / half;
        let sign = if halves_ago.is_multiple_of(2) {
            self.sign
        } else {
            -self.sign
        };
        for axis in 0..2 {
            sums.codes[axis] += u32::from(readings.currents[axis]);
            sums.current[axis] += i64::from(current[axis]);
            sums.voltage[axis] += i64::from(voltage[axis]);
            if ended {
                sums.response[axis] += i64::from(current[axis] * sign);
            }
        }
        sums.responses += u32::from(ended);
        self.since += 1;
        if self.since >= half.get() {
            self.since = 0;
            self.sign = -self.sign;
        }
    }
}
