//! Creates the current loop of a motor from the settings, and refuses what it cannot control.

use super::axis::{Gains, Winding};
use super::brushed::Brushed;
use super::foc::{Dq, Foc};
use super::means::Sums;
use super::operating_point::Fixed;
use super::zero::ConverterZero;
use super::{CurrentLoop, DEMAND_CONTROL_PERIODS, Demand, Motor};
use crate::math::to_i32;
use crate::motor::board_limits::SupplyTooHigh;
use crate::motor::bridge::{CurrentSensing, Ratings};
use crate::motor::halls::COUNTS_PER_ELECTRICAL_TURN;
use crate::motor::index::Index;
use crate::motor::rotor::{ElectricalAngle, Mounting, Rotor, RotorSensor, Turn};
use crate::settings::{Setting, Settings};
use core::fmt;

/// Kind of motor at the bridge.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum MotorKind {
    /// Brushed motor between half bridges a and b.
    Brushed,
    /// Permanent-magnet motor with three phases.
    ThreePhase,
}

/// Parameters of a current loop.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Config {
    /// Kind of the motor.
    pub kind: MotorKind,
    /// Resistance of winding and bridge, ohm; of one phase, if there are three. Above zero.
    pub resistance: f32,
    /// Inductances of the axes d and q, henry, above zero. A brushed motor has the first one.
    pub inductance: [f32; 2],
    /// Torque per current at the rotor, N m/A. The current of a three-phase motor is its amplitude.
    pub torque_constant: f32,
    /// Largest current that the loop demands, A; above zero.
    pub current_limit: f32,
    /// Bandwidth of the closed loop, rad/s; at most a quarter of the PWM rate.
    pub bandwidth: f32,
    /// Rotor turns per turn of the output shaft.
    pub gear_ratio: f32,
    /// Rotor sensor of a three-phase motor.
    pub mounting: Mounting,
    /// Kind of the rotor sensor; a brushed motor ignores it. With an index, the offset of
    /// `mounting` is the electrical angle at its pulse.
    pub sensor: RotorSensor,
    /// Time for which both transistors of a half bridge are off at each edge, s; at most 2 % of the
    /// PWM period. The loop compensates it.
    pub dead_time: f32,
    /// Current that bridge and winding carry for as long as it takes, A.
    pub continuous_current: f32,
    /// PWM periods per control period.
    pub periods_per_control: u32,
}

/// Reason why a loop cannot be created.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum CurrentLoopError {
    /// A value is not finite, or not above zero.
    NotPositive {
        /// Name of the value.
        name: &'static str,
        /// The value.
        got: f32,
    },
    /// The bandwidth leaves fewer than four PWM periods per radian. The delay of a period and a
    /// half would then cost more than 21 degrees of phase margin.
    BandwidthTooHigh {
        /// The given bandwidth, rad/s.
        got: f32,
        /// The largest bandwidth at this PWM rate, rad/s.
        maximum: f32,
    },
    /// The board cannot measure 150 % of the current limit.
    CurrentTooHigh {
        /// The given limit, A.
        got: f32,
        /// The largest limit on this board, A.
        maximum: f32,
    },
    /// The bandwidth is too high for this inductance or resistance.
    GainTooLarge {
        /// `inductance` or `resistance`.
        name: &'static str,
        /// Bandwidth times this value, in SI units.
        got: f32,
        /// The largest product on this board.
        maximum: f32,
    },
    /// Hall sensors give another number of counts in a turn of the rotor.
    HallCounts {
        /// The given number.
        got: i32,
        /// [`COUNTS_PER_ELECTRICAL_TURN`] times the pole pairs.
        expected: i32,
    },
    /// The dead time is above 2 % of the PWM period.
    DeadTimeTooLong {
        /// The given dead time, s.
        got: f32,
        /// The longest dead time, s.
        maximum: f32,
    },
    /// An open bridge would charge the supply too high.
    SupplyTooHigh(SupplyTooHigh),
}

impl fmt::Display for CurrentLoopError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotPositive { name, got } => write!(out, "{name} = {got} must be above zero"),
            Self::BandwidthTooHigh { got, maximum } => write!(
                out,
                "bandwidth = {got} rad/s, at most {maximum} at this PWM rate"
            ),
            Self::CurrentTooHigh { got, maximum } => write!(
                out,
                "current limit = {got} A, at most {maximum} A on this board"
            ),
            Self::GainTooLarge { name, got, maximum } => write!(
                out,
                "bandwidth times {name} = {got}, at most {maximum} on this board"
            ),
            Self::HallCounts { got, expected } => {
                write!(out, "encoder_counts = {got}, {expected} with Hall sensors")
            }
            Self::DeadTimeTooLong { got, maximum } => {
                write!(out, "dead time = {got} s, at most {maximum} s")
            }
            Self::SupplyTooHigh(error) => error.fmt(out),
        }
    }
}

/// Largest sum of the currents of all half bridges, as a fraction of the current limit and of full
/// scale: gains and zeros of the converters are not exact.
const SUM: f32 = 0.2;
const SUM_ZERO: f32 = 0.02;
/// Current at which the bridge opens at once, in current limits.
const OVER_CURRENT: f32 = 1.5;

impl Config {
    /// Reads the parameters of the motor from the settings. `periods_per_control` is the number of
    /// PWM periods in a control period.
    pub fn from_settings(settings: &Settings, periods_per_control: u32) -> Self {
        let inductance = settings.si(Setting::Inductance);
        let inductance_q = settings.si_or(Setting::InductanceQ, Setting::Inductance);
        let three_phase = settings.get(Setting::MotorKind) != 0;
        let [bridge, winding] = [Setting::BridgeCurrent, Setting::WindingCurrent]
            .map(|current| settings.si_or(current, Setting::CurrentLimit));
        Self {
            kind: if three_phase {
                MotorKind::ThreePhase
            } else {
                MotorKind::Brushed
            },
            resistance: settings.si(Setting::Resistance),
            inductance: [inductance, inductance_q],
            torque_constant: settings.si(Setting::TorqueConstant),
            current_limit: settings.si(Setting::CurrentLimit),
            bandwidth: settings.si(Setting::CurrentBandwidth),
            gear_ratio: settings.si(Setting::GearRatio),
            mounting: Mounting {
                counts_per_turn: settings.get(Setting::EncoderCounts),
                pole_pairs: settings.get(Setting::PolePairs),
                offset: ElectricalAngle::from_milli_degrees(
                    settings.get(Setting::ElectricalOffset),
                ),
                reversed: settings.get(Setting::PhaseOrder) < 0,
            },
            sensor: RotorSensor::of(settings).unwrap_or(RotorSensor::Incremental),
            dead_time: settings.si(Setting::DeadTime),
            continuous_current: if bridge < winding { bridge } else { winding },
            periods_per_control,
        }
    }

    fn check(&self, ratings: &Ratings) -> Result<(), CurrentLoopError> {
        for (name, got) in [
            ("resistance", self.resistance),
            ("inductance", self.inductance[0]),
            ("inductance of the axis q", self.inductance[1]),
            ("torque constant", self.torque_constant),
            ("current limit", self.current_limit),
            ("bandwidth", self.bandwidth),
            ("gear ratio", self.gear_ratio),
        ] {
            if !(got > 0.0 && got.is_finite()) {
                return Err(CurrentLoopError::NotPositive { name, got });
            }
        }
        let (got, expected) = (
            self.mounting.counts_per_turn,
            COUNTS_PER_ELECTRICAL_TURN.saturating_mul(self.mounting.pole_pairs),
        );
        if self.sensor.has_halls() && got != expected {
            return Err(CurrentLoopError::HallCounts { got, expected });
        }
        let maximum = ratings.pwm_hz as f32 / 4.0;
        if self.bandwidth > maximum {
            return Err(CurrentLoopError::BandwidthTooHigh {
                got: self.bandwidth,
                maximum,
            });
        }
        let maximum = ratings.full_scale / OVER_CURRENT;
        if self.current_limit > maximum {
            return Err(CurrentLoopError::CurrentTooHigh {
                got: self.current_limit,
                maximum,
            });
        }
        let maximum = 0.02 / ratings.pwm_hz as f32;
        if !(0.0..=maximum).contains(&self.dead_time) {
            return Err(CurrentLoopError::DeadTimeTooLong {
                got: self.dead_time,
                maximum,
            });
        }
        Ok(())
    }
}

/// Returns the largest current limit of which the converters show 150 % in both directions, A.
pub fn largest_current(sensing: &CurrentSensing, ratings: &Ratings) -> f32 {
    // The end of the range is one code below full scale.
    let range = (sensing.range() + (1 << 15)) as f32 / (1 << 30) as f32;
    range * ratings.full_scale / OVER_CURRENT
}

impl Config {
    /// Checks that the converters show 150 % of the current limit in both directions.
    ///
    /// # Errors
    /// [`CurrentLoopError::CurrentTooHigh`].
    pub fn check_range(
        &self,
        sensing: &CurrentSensing,
        ratings: &Ratings,
    ) -> Result<(), CurrentLoopError> {
        let maximum = largest_current(sensing, ratings);
        if self.current_limit > maximum {
            return Err(CurrentLoopError::CurrentTooHigh {
                got: self.current_limit,
                maximum,
            });
        }
        Ok(())
    }

    /// Creates the controllers of a three-phase motor at a power stage.
    ///
    /// # Errors
    /// [`CurrentLoopError::GainTooLarge`] if a gain exceeds its fixed-point format.
    pub fn field_oriented(&self, ratings: &Ratings) -> Result<Foc, CurrentLoopError> {
        let [d, q] = self.inductance;
        let gains = [self.gains(d, ratings)?, self.gains(q, ratings)?];
        Ok(Foc::new(gains, self.dead_counts(ratings)))
    }

    /// Returns what stays the same while the motor runs at a power stage.
    pub fn fixed(&self, ratings: &Ratings) -> Fixed {
        let pole_pairs = self.mounting.pole_pairs as f32;
        let (electrical_per_rotor, flux) = match self.kind {
            MotorKind::Brushed => (0.0, 0.0),
            MotorKind::ThreePhase => (
                pole_pairs * Rotor::new(self.mounting).direction() as f32,
                self.torque_constant / (1.5 * pole_pairs),
            ),
        };
        Fixed {
            ratings: *ratings,
            electrical_per_shaft: electrical_per_rotor * self.gear_ratio,
            inductance: self.inductance,
            flux,
            resistance: self.resistance,
            continuous_current: self.continuous_current,
            emf: self.gear_ratio
                * match self.kind {
                    MotorKind::Brushed => self.torque_constant,
                    // Root 3 / 1.5 of the torque constant.
                    MotorKind::ThreePhase => self.torque_constant * 1.154_700_5,
                },
        }
    }

    fn gains(&self, inductance: f32, ratings: &Ratings) -> Result<Gains, CurrentLoopError> {
        Gains::new(&Winding {
            resistance: self.resistance,
            inductance,
            bandwidth: self.bandwidth,
            full_scale: ratings.full_scale,
            rate_hz: ratings.pwm_hz as f32,
        })
    }

    /// Returns the compare counts that the dead time takes from a half bridge.
    fn dead_counts(&self, ratings: &Ratings) -> i32 {
        let dead = self.dead_time * ratings.pwm_hz as f32 * f32::from(ratings.period);
        (dead + 0.5) as i32
    }
}

impl CurrentLoop {
    /// Creates the loop of a motor at a power stage. The bridge is off until the first demand.
    ///
    /// # Errors
    /// [`CurrentLoopError`] with the value that is out of its bounds, and the bound.
    pub fn new(config: &Config, ratings: &Ratings) -> Result<Self, CurrentLoopError> {
        config.check(ratings)?;
        let motor = match config.kind {
            MotorKind::Brushed => {
                let gains = config.gains(config.inductance[0], ratings)?;
                Motor::Brushed(Brushed::new(gains, config.dead_counts(ratings)))
            }
            MotorKind::ThreePhase => Motor::ThreePhase(
                config.field_oriented(ratings)?,
                Rotor::new(config.mounting),
                Turn::new(config.mounting),
            ),
        };
        let both = matches!(motor, Motor::ThreePhase(..));
        let mut current_loop = Self {
            motor,
            sensing: CurrentSensing::default(),
            zero: ConverterZero::new(both, 0.0),
            third_zero: CurrentSensing::default().zero[1],
            fixed: config.fixed(ratings),
            current_limit: 0,
            over_current: 0,
            wanted_over_current: 0,
            largest_sum: 0,
            demand: Demand::default(),
            left: 0,
            life: DEMAND_CONTROL_PERIODS.saturating_mul(config.periods_per_control),
            excess: 0,
            over_voltage: false,
            shorted: false,
            sums: Sums::default(),
            probe: super::probe::Probe::default(),
            compares: [0; 3],
            measured: Dq::default(),
            compensation: None,
            index: (config.sensor == RotorSensor::Indexed).then(|| Index::new(config.mounting)),
        };
        current_loop.set_limits(config);
        Ok(current_loop)
    }

    /// Takes over the current limit of `config`, and its continuous current. The demand in force
    /// stays until the next one. A limit beyond what [`Self::new`] accepts ends at the range of the
    /// converters.
    pub fn set_limits(&mut self, config: &Config) {
        let full_scale = self.fixed.ratings.full_scale;
        let per_ampere = (1 << 30) as f32 / full_scale;
        let before = self.current_limit;
        self.current_limit = to_i32(config.current_limit * per_ampere);
        // The largest code is one below full scale.
        self.wanted_over_current = to_i32(OVER_CURRENT * config.current_limit * per_ampere);
        self.largest_sum =
            to_i32((SUM * config.current_limit + SUM_ZERO * full_scale) * per_ampere);
        self.zero.set_limit(config.current_limit / full_scale);
        self.fixed.continuous_current = config.continuous_current;
        if let Some(compensation) = &mut self.compensation {
            let change = self.current_limit.saturating_sub(before);
            compensation.left = compensation.left.saturating_add(change);
        }
        self.fit_range();
    }
}
