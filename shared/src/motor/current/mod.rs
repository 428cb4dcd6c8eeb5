//! Current control: everything that the PWM interrupt of a drive does.
//!
//! * [`CurrentLoop`]: follows demands of the control task, one PWM period at a time
//! * `means`: what was measured since the last control period
//! * `axis`: PI controller of one current
//! * `dead_time`: compensation of the dead time
//! * `cogging`: adds the current that cancels the cogging torque
//! * `circle`: the limit of the voltage
//! * `brushed`: a brushed motor between two half bridges
//! * [`foc`]: field-oriented control of a three-phase motor
//! * `probe`: voltages instead of currents, for the calibration
//! * `operating_point`: supply voltage and speed, prepared by the control task
//! * `zero`: follows the zero of the current converters
//! * `setup`: creates the loop from the settings
//!
//! Currents are integers whose full scale, 2^30, is the board's. Voltages are integers whose full
//! scale, 2^24, is [`VOLTAGE_FULL_SCALE`].

mod axis;
mod brushed;
mod circle;
mod cogging;
mod dead_time;
pub mod foc;
mod means;
mod operating_point;
mod probe;
mod setup;
mod zero;

pub use axis::bandwidth_bound;
pub use means::{Electrical, Means};
pub use operating_point::{Fixed, OperatingPoint};
pub use probe::{Excitation, Frame, Measurement};
pub use setup::{Config, CurrentLoopError, MotorKind, largest_current};
pub use zero::ZERO_ERROR;

use super::bridge::{CurrentSensing, PowerStage, Readings};
use super::capture::Signals;
use super::cogging::Wave;
use super::index::Index;
use super::rotor::{ElectricalAngle, Rotor, Turn};
use crate::math::{Bound, root_of_sum, to_i16, to_i32};
use brushed::Brushed;
use cogging::Cogging;
use foc::{Dq, Foc};
use means::Sums;
use probe::Probe;
use zero::ConverterZero;

/// Voltage that counts as full scale, V. It bounds the supply voltage that the loop uses.
pub const VOLTAGE_FULL_SCALE: f32 = 64.0;
/// Lowest supply voltage at which the bridge is driven, V. Below it, and if the supply voltage is
/// unknown, all half bridges give the same voltage.
pub const MIN_SUPPLY_VOLTAGE: f32 = 5.0;
/// Number of control periods after which a demand expires.
pub const DEMAND_CONTROL_PERIODS: u32 = 3;

/// What the bridge does until the next demand.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub enum BridgeDemand {
    /// All transistors are open: the motor turns freely.
    #[default]
    Off,
    /// The reaction to a fault that may brake. All transistors are open while the back-EMF is below
    /// the supply voltage. Above it the windings are shorted, if bridge and winding carry the
    /// current of the short for as long as it takes.
    Brake,
    /// The current loop is on, with this demand in A: the current of a brushed motor's winding, or
    /// the current that makes the torque of a three-phase motor (its amplitude).
    Current(f32),
    /// As [`Self::Current`], with a second current in the axis d of a three-phase motor, A. It
    /// makes no torque. It turns braking power into heat, or shows whether the rotor's angle is
    /// right.
    Braking {
        /// The current that makes the torque, A.
        current: f32,
        /// The current in d, A. It is limited to what `current` leaves of the current limit.
        direct: f32,
    },
    /// As [`Self::Current`], along the magnets' flux of a rotor that stands at the angle `field`,
    /// wherever the rotor is. It turns the rotor there. A brushed motor's bridge opens.
    Align {
        /// The current, A.
        current: f32,
        /// Where it points.
        field: ElectricalAngle,
    },
    /// The rotor is this angle ahead of where its sensor shows it. Corrects the angle for good, and
    /// demands no current.
    Aligned(ElectricalAngle),
}

/// Number of PWM periods with an over-current or an over-voltage in one control period after which
/// the bridge stays open. One alone may be a disturbed sample.
const TRIP_PERIODS: u32 = 2;

/// Part at the end of a converter's range that counts as over-current: two steps of one with 12
/// bits. 2^30 is full scale.
const RANGE_END: i32 = 1 << 20;

/// Controller of the motor's kind.
#[derive(Clone, Debug)]
enum Motor {
    Brushed(Brushed),
    ThreePhase(Foc, Rotor, Turn),
}

/// Current against the cogging torque, and what it leaves of the current limit; 2^30 is full scale.
#[derive(Clone, Debug)]
struct Compensation {
    cogging: Cogging,
    left: i32,
}

/// State of the PWM interrupt.
#[derive(Clone, Debug)]
pub struct CurrentLoop {
    motor: Motor,
    sensing: CurrentSensing,
    zero: ConverterZero,
    /// Zero of half bridge c.
    third_zero: i32,
    fixed: Fixed,
    /// Largest current that is demanded, and largest with which the bridge stays on; 2^30 is full
    /// scale.
    current_limit: i32,
    over_current: i32,
    /// The second one on a board that can measure it in both directions.
    wanted_over_current: i32,

    demand: Demand,
    /// PWM periods for which the demand is still valid, and for which a new one is.
    left: u32,
    life: u32,
    /// PWM periods with an over-current or an over-voltage in this control period. From
    /// [`TRIP_PERIODS`] on, the bridge stays open.
    excess: u32,
    /// The newest of them was an over-voltage.
    over_voltage: bool,
    /// The demand is to brake, and shorts the windings.
    shorted: bool,
    /// Compare values of the period that ends with the next readings.
    compares: [u16; 3],
    /// Largest sum of the currents of all half bridges, which should be 0; 2^30 is full scale.
    largest_sum: i32,
    /// Measurements since the last call of [`Self::take_means`].
    sums: Sums,
    probe: Probe,
    /// Currents in the rotor's axes in the newest period; 2^26 is full scale.
    measured: Dq,
    compensation: Option<Compensation>,
    /// Index of an incremental encoder, if it has one.
    index: Option<Index>,
}

/// Prepared demand.
#[derive(Clone, Copy, Debug, Default)]
struct Demand {
    action: Action,
    point: OperatingPoint,
    /// Angle of the rotor's axes that replaces the angle of the rotor.
    axes: Option<ElectricalAngle>,
    /// Velocity of the output shaft, 0.01 rad/s.
    velocity: i16,
    /// The bridge is open, and the back-EMF drives no current through its diodes.
    no_current: bool,
}

/// What the controllers of the currents follow in one PWM period.
#[derive(Clone, Copy, Debug)]
struct Target<'a> {
    current: Dq,
    /// As in [`Demand`].
    axes: Option<ElectricalAngle>,
    compensation: Option<&'a Compensation>,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
enum Action {
    #[default]
    Off,
    Brake,
    /// The currents in q and d; 2^30 is full scale.
    Current(i32, i32),
    /// The excitation of the probe.
    Excite,
    /// The probe measures while the bridge is open.
    Listen,
}

impl CurrentLoop {
    /// Sets the demand that the bridge follows from the next PWM period on, with the supply
    /// voltage, V, and the velocity of the output shaft, rad/s. It is valid for
    /// [`DEMAND_CONTROL_PERIODS`] control periods; then the bridge opens.
    ///
    /// A demand beyond the current limit counts as the limit, and NaN as 0 A. Without a usable
    /// supply voltage the voltage is 0.
    ///
    /// After an over-current the bridge stays open whatever is demanded, until the demand is
    /// [`BridgeDemand::Off`] once. After an over-voltage, [`BridgeDemand::Brake`] ends this, too.
    pub fn demand(&mut self, demand: BridgeDemand, supply_voltage: f32, shaft_velocity: f32) {
        let (mut axes, mut shaft_velocity) = (None, shaft_velocity);
        if demand == BridgeDemand::Brake && self.over_voltage {
            self.excess = 0;
        }
        let tripped = self.excess >= TRIP_PERIODS;
        self.shorted = demand == BridgeDemand::Brake
            && !tripped
            && self
                .fixed
                .shorts(supply_voltage, shaft_velocity, self.shorted);
        let action = match demand {
            BridgeDemand::Off => {
                self.excess = 0;
                Action::Off
            }
            BridgeDemand::Brake if self.shorted => Action::Brake,
            BridgeDemand::Brake => Action::Off,
            _ if tripped => Action::Off,
            BridgeDemand::Current(amperes) => Action::Current(self.limited(amperes), 0),
            BridgeDemand::Braking { current, direct } => {
                let q = self.limited(current);
                let (limit, used) = (self.current_limit as f32, self.largest_q(q) as f32);
                let left = to_i32(root_of_sum(limit * limit - used * used));
                Action::Current(q, Bound::new(left - 1).limit(self.limited(direct)))
            }
            BridgeDemand::Align { current, field } => match &self.motor {
                Motor::Brushed(_) => Action::Off,
                Motor::ThreePhase(_, rotor, _) => {
                    axes = Some(rotor.axes_of_field(field));
                    shaft_velocity = 0.0;
                    Action::Current(self.limited(current), 0)
                }
            },
            BridgeDemand::Aligned(error) => match &mut self.motor {
                Motor::Brushed(_) => Action::Off,
                Motor::ThreePhase(foc, rotor, turn) => {
                    rotor.correct(error);
                    if let Some(index) = &mut self.index {
                        index.align(turn);
                    }
                    // The integrals belong to the axes of the field.
                    foc.reset();
                    Action::Current(0, 0)
                }
            },
        };
        self.demand = Demand {
            action,
            point: OperatingPoint::new(&self.fixed, supply_voltage, shaft_velocity),
            axes,
            velocity: to_i16(shaft_velocity * 100.0),
            no_current: demand == BridgeDemand::Off
                && (self.fixed.emf * shaft_velocity).abs() < 0.5 * supply_voltage,
        };
        self.left = self.life;
    }

    /// Sets the offset and the gain of the current measurement. The offset is followed while the
    /// bridge is open. Half bridge c has the offset of b until its own is known, 100 ms after the
    /// bridge has opened.
    pub fn set_sensing(&mut self, sensing: CurrentSensing) {
        self.sensing = sensing;
        self.third_zero = sensing.zero[1];
        self.zero.set(sensing.zero);
        self.fit_range();
    }

    /// Returns the current limit, A, and the codes of half bridges a, b and c without current.
    pub fn over_current(&self) -> (f32, [i32; 3]) {
        let ampere = self.fixed.ratings.full_scale / (1 << 30) as f32;
        let [a, b] = self.sensing.zero;
        (self.current_limit as f32 * ampere, [a, b, self.third_zero])
    }

    /// Lowers the over-current to what the converters show in both directions.
    fn fit_range(&mut self) {
        let range = self.sensing.range() - RANGE_END;
        self.over_current = Ord::min(self.wanted_over_current, range);
    }

    /// Adds a current that cancels the cogging torque to every demand from now on. It has this
    /// number of periods in an electrical turn. What it leaves of the current limit is left for
    /// demands. A brushed motor ignores it. 0 periods end it.
    pub fn set_cogging(&mut self, periods: i32, wave: Wave) {
        let full_scale = self.fixed.ratings.full_scale;
        self.compensation = (periods != 0).then(|| Compensation {
            cogging: Cogging::new(periods, wave, full_scale),
            left: self
                .current_limit
                .saturating_sub(cogging::amplitude(wave, full_scale)),
        });
    }

    /// Takes a pulse of the encoder's index at this count of the rotor sensor
    /// ([`Readings::rotor`]). The next [`Self::take_means`] evaluates it. Without an index
    /// ([`Config::index`]), it is ignored.
    pub fn index_pulse(&mut self, count: u32) {
        if let Some(index) = &mut self.index {
            index.pulse(count);
        }
    }

    /// Excites the motor with a voltage from the next PWM period on, instead of controlling its
    /// current. As a demand, it is valid for [`DEMAND_CONTROL_PERIODS`] control periods, and the
    /// bridge opens beyond 150 % of the current limit. The sensing of the excitation stays in
    /// force.
    pub fn excite(&mut self, excitation: &Excitation, supply_voltage: f32) {
        let action = if self.excess >= TRIP_PERIODS {
            Action::Off
        } else if excitation.open {
            Action::Listen
        } else {
            Action::Excite
        };
        self.demand = Demand {
            action,
            point: OperatingPoint::new(&self.fixed, supply_voltage, 0.0),
            axes: None,
            velocity: 0,
            no_current: false,
        };
        self.sensing = excitation.sensing;
        self.fit_range();
        self.probe.excite(excitation, &self.demand.point);
        self.left = self.life;
    }

    /// Returns what the excitation has measured since the last call; `None` without a sample.
    pub fn take_measurement(&mut self, supply_voltage: f32) -> Option<Measurement> {
        let index = self.index.as_ref().and_then(Index::newest);
        let measured = self.probe.take(&self.fixed.ratings, supply_voltage)?;
        Some(Measurement { index, ..measured })
    }

    /// Returns the largest current in q that a demand causes together with the wave against the
    /// cogging torque.
    fn largest_q(&self, demand: i32) -> i32 {
        let wave = self.compensation.as_ref();
        wave.map_or(demand, |Compensation { left, .. }| {
            let demand = Bound::new(*left).limit(demand).saturating_abs();
            demand.saturating_add(self.current_limit.saturating_sub(*left))
        })
    }

    /// Converts a current, A, to the scale of the loop, limited to the current limit.
    fn limited(&self, amperes: f32) -> i32 {
        let scale = (1 << 30) as f32 / self.fixed.ratings.full_scale;
        Bound::new(self.current_limit - 1).limit(to_i32(amperes * scale))
    }

    /// Returns what was measured since the last call; `None` if no sample was taken.
    pub fn take_means(&mut self) -> Option<Means> {
        let sums = core::mem::take(&mut self.sums);
        let tripped = self.excess >= TRIP_PERIODS;
        if !tripped {
            self.excess = 0;
        }
        let mut means = sums.means(&self.fixed, self.life / DEMAND_CONTROL_PERIODS)?;
        means.electrical.over_current = tripped && !self.over_voltage;
        means.electrical.over_voltage = tripped && self.over_voltage;
        means.electrical.wrong_zero = self.follow_zero(sums.idle_codes());
        if let Motor::ThreePhase(_, rotor, turn) = &mut self.motor {
            if let Some(index) = &mut self.index {
                let driven = means.electrical.voltage.is_some();
                means.electrical.index = index.update(rotor, turn, driven);
                if index.settles() {
                    means.electrical.voltage = None;
                }
            }
            let angle = rotor.angle(turn.count());
            means.electrical.angle = Some(angle);
            if let Some(axes) = self.demand.axes {
                let ahead = rotor.field_of_axes(axes).0 - angle.0;
                means.electrical.ahead = Some(ElectricalAngle(ahead));
            }
        }
        Some(means)
    }

    /// Takes [`Sums::idle_codes`]. Returns whether the zero of the current converters is wrong.
    fn follow_zero(&mut self, codes: Option<(i32, [i32; 3])>) -> bool {
        let zero = self.zero.update(codes.filter(|_| self.demand.no_current));
        if let Some([a, b, c]) = zero {
            self.sensing.zero = [a, b];
            self.third_zero = c;
            self.fit_range();
        }
        self.zero.is_wrong()
    }

    /// Returns the signals of the PWM period that had these `readings` and led to `stage`, for a
    /// recording.
    pub fn signals(&self, readings: &Readings, stage: PowerStage) -> Signals {
        let [a, b] = self.sensing.currents(readings.currents);
        let Dq { d, q } = self.measured;
        let demand = match self.demand.action {
            Action::Current(q, _) => q,
            Action::Off | Action::Brake | Action::Excite | Action::Listen => 0,
        };
        Signals {
            readings: *readings,
            stage,
            currents: [a, b, d << 4, q << 4, demand],
            velocity: self.demand.velocity,
        }
    }

    /// Returns the currents of half bridges a and b, and the sum of all. Where a low side conducted
    /// too briefly for a sample, the current follows from the other ones, and the sum is 0. Half
    /// bridge c of a brushed motor is not connected.
    #[inline]
    fn currents(&self, readings: &Readings) -> ([i32; 2], i32) {
        let [a, b] = self.sensing.currents(readings.currents);
        let c = match (&self.motor, readings.third) {
            (Motor::Brushed(_), _) => 0,
            (Motor::ThreePhase(..), Some(code)) => self.sensing.third(code, self.third_zero),
            (Motor::ThreePhase(..), None) => return ([a, b], 0),
        };
        let bad = self
            .compares
            .map(|compare| compare > self.fixed.ratings.sampled);
        match bad {
            [true, ..] => ([b.saturating_add(c).saturating_neg(), b], 0),
            [_, true, _] => ([a, a.saturating_add(c).saturating_neg()], 0),
            [.., true] => ([a, b], 0),
            _ => ([a, b], a.saturating_add(b).saturating_add(c)),
        }
    }

    /// Runs one PWM period: computes the command for the next period.
    ///
    /// It is defined for every input. The bridge is off while a phase current exceeds 150 % of the
    /// current limit, and while the supply voltage is too high. A short is not opened because of
    /// the voltage: it returns nothing to the supply.
    #[inline]
    pub fn period(&mut self, readings: &Readings) -> PowerStage {
        let (currents, sum) = self.currents(readings);
        let largest = self.motor.largest(currents);
        let action = if self.left == 0 {
            Action::Off
        } else {
            self.left -= 1;
            self.demand.action
        };
        // The currents of an open bridge flow past the shunts.
        let driven = matches!(action, Action::Current(..));
        self.sums
            .add_sum(driven && sum.saturating_abs() > self.largest_sum);
        let too_large = largest > self.over_current;
        let too_high = readings.over_voltage && action != Action::Brake;
        let (stage, current) = match action {
            Action::Current(q, d) if !too_large && !too_high => {
                let point = &self.demand.point;
                let target = Target {
                    current: Dq { d, q },
                    axes: self.demand.axes,
                    compensation: self.compensation.as_ref(),
                };
                let sums = &mut self.sums;
                let (compare, current) =
                    self.motor
                        .step(readings.rotor, currents, &target, point, sums);
                if point.circle.radius() == 0 {
                    self.motor.reset();
                }
                self.measured = current;
                (PowerStage::Drive(compare), current.q)
            }
            Action::Excite if !too_large && !too_high => {
                let point = &self.demand.point;
                let compare = self.probe.step(&self.motor, *readings, currents, point);
                (
                    PowerStage::Drive(compare),
                    self.motor.without_control(currents),
                )
            }
            Action::Listen => {
                self.motor.reset();
                self.probe.listen(readings);
                (PowerStage::Off, 0)
            }
            action => {
                self.motor.reset();
                if action != Action::Off && (too_large || too_high) {
                    self.over_voltage = !too_large;
                    self.excess = self.excess.saturating_add(1);
                    if self.excess >= TRIP_PERIODS {
                        self.left = 0;
                    }
                }
                // One disturbed sample does not open a short.
                let stage = if action == Action::Brake && self.excess < TRIP_PERIODS {
                    PowerStage::Brake
                } else {
                    let ([a, b], c) = (readings.currents, readings.third);
                    self.sums.add_idle([a, b, c.unwrap_or(1 << 15)]);
                    PowerStage::Off
                };
                let current = self.motor.without_control(currents);
                self.measured = Dq { d: 0, q: current };
                (stage, current)
            }
        };
        self.sums.add_current(current);
        self.compares = match stage {
            PowerStage::Drive(compares) => compares,
            PowerStage::Off | PowerStage::Brake => [0; 3],
        };
        stage
    }
}

impl Motor {
    /// Returns the largest current of a half bridge; 2^30 is full scale.
    #[inline]
    fn largest(&self, [a, b]: [i32; 2]) -> i32 {
        let (a_size, b_size) = (a.saturating_abs(), b.saturating_abs());
        match self {
            Self::Brushed(_) => a_size,
            Self::ThreePhase(..) => {
                let c_size = a.saturating_add(b).saturating_abs();
                let larger = if a_size > b_size { a_size } else { b_size };
                if c_size > larger { c_size } else { larger }
            }
        }
    }

    /// Returns the current that is reported while the loop is off: of the winding, or the largest
    /// of three phases, whose direction in the rotor is then of no use. 2^26 is full scale.
    #[inline]
    fn without_control(&self, currents: [i32; 2]) -> i32 {
        match self {
            Self::Brushed(_) => currents[0] >> 4,
            Self::ThreePhase(..) => self.largest(currents) >> 4,
        }
    }

    /// Computes compare values, and the measured currents (2^26 is full scale), with q in the
    /// direction of the demand. Adds the voltages to `sums`.
    #[inline]
    fn step(
        &mut self,
        reading: u32,
        currents: [i32; 2],
        target: &Target,
        point: &OperatingPoint,
        sums: &mut Sums,
    ) -> ([u16; 3], Dq) {
        match self {
            Self::Brushed(brushed) => {
                let q = currents[0];
                let (compare, voltage) = brushed.step(q, target.current.q, point);
                sums.add_voltage(Dq { d: 0, q: voltage }, 0);
                (compare, Dq { d: 0, q: q >> 4 })
            }
            Self::ThreePhase(foc, rotor, turn) => {
                let (measured, direction) = (rotor.angle(turn.update(reading)), rotor.direction());
                let (angle, demand) = (target.axes.unwrap_or(measured), target.current);
                let q = match target.compensation {
                    Some(Compensation { cogging, left }) if target.axes.is_none() => {
                        Bound::new(*left).limit(demand.q) + cogging.current(angle)
                    }
                    _ => demand.q,
                };
                let q = q * direction;
                let step = foc.step(angle, currents, Dq { q, ..demand }, point);
                let Dq { d, q } = step.voltage;
                sums.add_voltage(
                    Dq {
                        d,
                        q: q * direction,
                    },
                    step.current.d,
                );
                let measured = Dq {
                    q: step.current.q * direction,
                    ..step.current
                };
                (step.compare, measured)
            }
        }
    }

    #[inline]
    fn reset(&mut self) {
        match self {
            Self::Brushed(brushed) => brushed.reset(),
            Self::ThreePhase(foc, ..) => foc.reset(),
        }
    }
}
