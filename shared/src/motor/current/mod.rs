//! Current control: everything that the PWM interrupt of a drive does.
//!
//! * [`CurrentLoop`]: follows demands of the control task, one PWM period at a time
//! * `axis`: PI controller of one current
//! * `dead_time`: compensation of the dead time
//! * `brushed`: a brushed motor between two half bridges
//! * [`foc`]: field-oriented control of a three-phase motor
//! * `probe`: voltages instead of currents, for the calibration
//! * `operating_point`: supply voltage and speed, prepared by the control task
//! * `setup`: creates the loop from the settings
//!
//! Currents are integers whose full scale, 2^30, is the board's. Voltages are integers whose full
//! scale, 2^24, is [`VOLTAGE_FULL_SCALE`].

mod axis;
mod brushed;
mod dead_time;
pub mod foc;
mod operating_point;
mod probe;
mod setup;

pub use probe::{Excitation, Frame, Measurement};
pub use setup::{Config, CurrentLoopError, MotorKind};

use super::bridge::{CurrentSensing, PowerStage, Readings};
use super::rotor::Rotor;
use crate::math::{Bound, to_i32};
use brushed::Brushed;
use foc::{Dq, Foc};
use operating_point::{Fixed, OperatingPoint};
use probe::Probe;

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
    /// The windings are shorted: the motor resists motion.
    Brake,
    /// The current loop is on, with this demand in A: the current of a brushed motor's winding, or
    /// the current that makes the torque of a three-phase motor (its amplitude).
    Current(f32),
}

/// Controller of the motor's kind.
#[derive(Clone, Debug)]
enum Motor {
    Brushed(Brushed),
    ThreePhase(Foc, Rotor),
}

/// State of the PWM interrupt.
#[derive(Clone, Debug)]
pub struct CurrentLoop {
    motor: Motor,
    sensing: CurrentSensing,
    fixed: Fixed,
    /// Largest current that is demanded, and largest with which the bridge stays on; 2^30 is full
    /// scale.
    current_limit: i32,
    over_current: i32,

    demand: Demand,
    /// PWM periods for which the demand is still valid, and for which a new one is.
    left: u32,
    life: u32,
    /// Sum of the measured currents since the last call of [`Self::take_mean`], and their number.
    sum: i64,
    samples: u32,
    probe: Probe,
}

/// Prepared demand.
#[derive(Clone, Copy, Debug, Default)]
struct Demand {
    action: Action,
    point: OperatingPoint,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
enum Action {
    #[default]
    Off,
    Brake,
    /// The current; 2^30 is full scale.
    Current(i32),
    /// The excitation of the probe.
    Excite,
}

impl CurrentLoop {
    /// Sets the demand that the bridge follows from the next PWM period on, with the supply
    /// voltage, V, and the velocity of the output shaft, rad/s. It is valid for
    /// [`DEMAND_CONTROL_PERIODS`] control periods; then the bridge opens.
    ///
    /// A demand beyond the current limit counts as the limit, and NaN as 0 A. Without a usable
    /// supply voltage the voltage is 0.
    pub fn demand(&mut self, demand: BridgeDemand, supply_voltage: f32, shaft_velocity: f32) {
        let action = match demand {
            BridgeDemand::Off => Action::Off,
            BridgeDemand::Brake => Action::Brake,
            BridgeDemand::Current(amperes) => {
                let scale = (1 << 30) as f32 / self.fixed.ratings.full_scale;
                let current = to_i32(amperes * scale);
                Action::Current(Bound::new(self.current_limit - 1).limit(current))
            }
        };
        self.demand = Demand {
            action,
            point: OperatingPoint::new(&self.fixed, supply_voltage, shaft_velocity),
        };
        self.left = self.life;
    }

    /// Sets the offset and the gain of the current measurement.
    pub fn set_sensing(&mut self, sensing: CurrentSensing) {
        self.sensing = sensing;
    }

    /// Excites the motor with a voltage from the next PWM period on, instead of controlling its
    /// current. As a demand, it is valid for [`DEMAND_CONTROL_PERIODS`] control periods, and the
    /// bridge opens beyond 150 % of the current limit. The sensing of the excitation stays in
    /// force.
    pub fn excite(&mut self, excitation: &Excitation, supply_voltage: f32) {
        self.demand = Demand {
            action: Action::Excite,
            point: OperatingPoint::new(&self.fixed, supply_voltage, 0.0),
        };
        self.sensing = excitation.sensing;
        self.probe.excite(excitation, &self.demand.point);
        self.left = self.life;
    }

    /// Returns what the excitation has measured since the last call; `None` without a sample.
    pub fn take_measurement(&mut self, supply_voltage: f32) -> Option<Measurement> {
        self.probe.take(&self.fixed.ratings, supply_voltage)
    }

    /// Returns the mean of the measured current since the last call, A; `None` if no sample was
    /// taken.
    pub fn take_mean(&mut self) -> Option<f32> {
        let (sum, samples) = (self.sum, self.samples);
        (self.sum, self.samples) = (0, 0);
        let unit = self.fixed.ratings.full_scale / (1 << 30) as f32;
        (samples > 0).then(|| sum as f32 * unit / samples as f32)
    }

    /// Runs one PWM period: computes the command for the next period.
    ///
    /// It is defined for every input. The bridge is off while a phase current exceeds 150 % of the
    /// current limit. It is off instead of braking while a phase current exceeds the current limit,
    /// because only its resistance limits the current of a shorted motor.
    #[inline]
    pub fn period(&mut self, readings: &Readings) -> PowerStage {
        let currents = self.sensing.currents(readings.currents);
        let largest = self.motor.largest(currents);
        let action = if self.left == 0 {
            Action::Off
        } else {
            self.left -= 1;
            self.demand.action
        };
        let (stage, current) = match action {
            Action::Current(demand) if largest <= self.over_current => {
                let point = &self.demand.point;
                let (compare, current) = self.motor.step(readings.rotor, currents, demand, point);
                if point.voltage_limit == 0 {
                    self.motor.reset();
                }
                (PowerStage::Drive(compare), current)
            }
            Action::Excite if largest <= self.over_current => {
                let point = &self.demand.point;
                let compare = self.probe.step(&self.motor, *readings, currents, point);
                (
                    PowerStage::Drive(compare),
                    self.motor.without_control(currents),
                )
            }
            action => {
                self.motor.reset();
                let brakes = action == Action::Brake && largest <= self.current_limit;
                let stage = if brakes {
                    PowerStage::Brake
                } else {
                    PowerStage::Off
                };
                (stage, self.motor.without_control(currents))
            }
        };
        self.sum += i64::from(current);
        self.samples = self.samples.saturating_add(1);
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
    /// of three phases, whose direction in the rotor is then of no use.
    #[inline]
    fn without_control(&self, currents: [i32; 2]) -> i32 {
        match self {
            Self::Brushed(_) => currents[0],
            Self::ThreePhase(..) => self.largest(currents),
        }
    }

    /// Computes compare values, and the measured current in the direction of the demand.
    #[inline]
    fn step(
        &mut self,
        count: u32,
        currents: [i32; 2],
        demand: i32,
        point: &OperatingPoint,
    ) -> ([u16; 3], i32) {
        match self {
            Self::Brushed(brushed) => (brushed.step(currents[0], demand, point), currents[0]),
            Self::ThreePhase(foc, rotor) => {
                let angle = rotor.angle(count);
                let q = demand * rotor.direction();
                let (compare, measured) = foc.step(angle, currents, Dq { d: 0, q }, point);
                (compare, measured.q * rotor.direction())
            }
        }
    }

    #[inline]
    fn reset(&mut self) {
        match self {
            Self::Brushed(brushed) => brushed.reset(),
            Self::ThreePhase(foc, _) => foc.reset(),
        }
    }
}
