//! Measurements of the PWM interrupt for the control task: sums over the PWM periods of a control
//! period.

use super::VOLTAGE_FULL_SCALE;
use super::foc::Dq;
use super::operating_point::Fixed;
use crate::motor::index::Finding;
use crate::motor::rotor::ElectricalAngle;

/// Largest number of periods whose sums do not overflow. More of them in a control period are an
/// overrun.
const MAX_SAMPLES: u32 = 64;

/// What was measured in a control period.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Means {
    /// Mean current, A: of the winding, or the current of a three-phase motor that makes the
    /// torque.
    pub current: f32,
    /// Further measurements.
    pub electrical: Electrical,
}

/// Measurements of the bridge that supervise the motor. The default is "nothing known, nothing
/// wrong".
#[allow(clippy::struct_excessive_bools)] // each is a finding, and all are independent
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Electrical {
    /// Mean voltages in d and q, V; the voltage of a brushed winding is that in q. `None` unless
    /// the current loop was on in every period.
    pub voltage: Option<[f32; 2]>,
    /// Mean current in d, A.
    pub direct: f32,
    /// Mean of the size of the current in d, A. It is larger than [`Self::direct`] if the current
    /// oscillates within the control period.
    pub direct_size: f32,
    /// Electrical angle of a three-phase rotor at the last sample of the current loop.
    pub angle: Option<ElectricalAngle>,
    /// How far the field of an alignment is ahead of the rotor where its sensor shows it; `None`
    /// while the rotor is not aligned.
    pub ahead: Option<ElectricalAngle>,
    /// What the index of an incremental encoder shows.
    pub index: Finding,
    /// Bridge currents exceeded 150 % of the current limit. The bridge is open and stays open.
    pub over_current: bool,
    /// The same of the supply voltage and its bound.
    pub over_voltage: bool,
    /// When the bridge was open last, a current converter showed more than 2 % of the current limit
    /// plus [`ZERO_ERROR`](super::ZERO_ERROR) of its full scale, for 20 control periods.
    pub wrong_zero: bool,
    /// The currents of the half bridges did not add up to 0 in most periods: a converter is wrong.
    pub wrong_sum: bool,
    /// The PWM interrupt ran less than half as often, or more than twice as often, as it must in a
    /// control period.
    pub overrun: bool,
}

/// Sums of one control period.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    current: i64,
    samples: u32,
    /// Sums of the voltages and of the current in d; 2^24 is full scale. They are right for up to
    /// [`MAX_SAMPLES`] periods.
    voltage: Dq,
    direct: i32,
    direct_size: i32,
    driven: u32,
    /// Sums of the current converters' codes in the periods in which the bridge was open.
    idle: [i32; 3],
    open: u32,
    /// Periods in which the currents did not add up to 0.
    unbalanced: u32,
}

impl Sums {
    /// Adds a current; 2^26 is full scale.
    #[inline]
    pub fn add_current(&mut self, current: i32) {
        self.current += i64::from(current);
        self.samples = self.samples.saturating_add(1);
    }

    /// Adds whether the currents of a period do not add up to 0.
    #[inline]
    pub fn add_sum(&mut self, wrong: bool) {
        self.unbalanced = self.unbalanced.saturating_add(u32::from(wrong));
    }

    /// Adds the voltages of a period, 2^24 is full scale, and its current in d, 2^26 is full scale.
    #[inline]
    pub fn add_voltage(&mut self, voltage: Dq, direct: i32) {
        self.voltage.d = self.voltage.d.wrapping_add(voltage.d);
        self.voltage.q = self.voltage.q.wrapping_add(voltage.q);
        let direct = direct >> 2;
        self.direct = self.direct.wrapping_add(direct);
        self.direct_size = self.direct_size.wrapping_add(direct.wrapping_abs());
        self.driven = self.driven.wrapping_add(1);
    }

    /// Adds the codes of the current converters of a period in which the bridge is open.
    #[inline]
    pub fn add_idle(&mut self, codes: [u16; 3]) {
        for (sum, code) in self.idle.iter_mut().zip(codes) {
            *sum = sum.wrapping_add(i32::from(code));
        }
        self.open = self.open.wrapping_add(1);
    }

    /// Returns the number of periods, 1 to [`MAX_SAMPLES`], and the sums of the current converters'
    /// codes; `None` unless the bridge was open in every period.
    pub fn idle_codes(&self) -> Option<(i32, [i32; 3])> {
        let open = self.open == self.samples && (1..=MAX_SAMPLES).contains(&self.samples);
        open.then_some((self.samples as i32, self.idle))
    }

    /// Computes the means; `None` without a sample. A control period has `expected` PWM periods.
    pub fn means(&self, fixed: &Fixed, expected: u32) -> Option<Means> {
        let samples = self.samples;
        if samples == 0 {
            return None;
        }
        let (full_scale, part) = (fixed.ratings.full_scale, 1.0 / samples as f32);
        let right = samples <= MAX_SAMPLES;
        let driven = self.driven == samples && right;
        let amperes = part * (full_scale / (1 << 24) as f32);
        let volts = part * (VOLTAGE_FULL_SCALE / (1 << 24) as f32);
        // The sum of a usual control period fits in 32 bits. The core converts it without a library
        // function, and the PWM interrupt waits meanwhile.
        let current = match i32::try_from(self.current) {
            Ok(sum) => sum as f32,
            Err(_) => self.current as f32,
        };
        Some(Means {
            current: current * (full_scale / (1 << 26) as f32) * part,
            electrical: Electrical {
                voltage: driven
                    .then_some([self.voltage.d as f32 * volts, self.voltage.q as f32 * volts]),
                direct: self.direct as f32 * amperes,
                direct_size: self.direct_size as f32 * amperes,
                angle: None,
                ahead: None,
                index: Finding::Nothing,
                over_current: false,
                over_voltage: false,
                wrong_zero: false,
                wrong_sum: self.unbalanced > samples / 2,
                overrun: samples < expected / 2 || samples > expected.saturating_mul(2),
            },
        })
    }
}
