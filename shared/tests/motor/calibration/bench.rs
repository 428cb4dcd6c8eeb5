//! Simulated motors for calibrations: random ones, with everything that a node does not know. They
//! are integrated eight times per PWM period, so that the results do not depend on the model's
//! steps.

use crate::random::Random;
use tautrack::link::{MotorModel, ThreePhaseModel, WindingModel};
use tautrack::motor::bridge::{PowerStage, Ratings};
use tautrack::motor::calibration::{Calibration, Inputs, Plan, Progress, Record, Refusal};
use tautrack::motor::current::{Config, CurrentLoop, MotorKind};
use tautrack::motor::halls::{COUNTS_PER_ELECTRICAL_TURN, Halls};
use tautrack::motor::model::Motor;
use tautrack::motor::rotor::{ElectricalAngle, Mounting, RotorSensor};
use tautrack::units::Angle;

pub const STAGE: Ratings = Ratings {
    pwm_hz: 20_000,
    period: 4_250,
    highest: 4_250,
    sampled: 4_250,
    full_scale: 64.0,
    highest_supply: f32::INFINITY,
};
pub const SUPPLY: f32 = 24.0;
/// Steps of the model per PWM period.
pub const STEPS: u32 = 8;
pub const PERIODS: u32 = 20;

/// A motor with everything that its node does not know.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    pub model: MotorModel,
    /// Leads b and c are swapped.
    pub swapped: bool,
    /// Codes at no current, less 2^15, and true gains of the converters.
    pub zero: [i32; 2],
    pub gain: [f64; 2],
    /// The rotor sensor reads up to one count too much.
    pub sensor_noise: bool,
    /// Hall sensors show the rotor, each displaced by some degrees.
    pub halls: Option<[f64; 3]>,
    pub current_limit: f32,
    pub calibration_current: f32,
}

pub struct Bench {
    pub truth: Truth,
    pub motor: Motor,
    pub current_loop: CurrentLoop,
    pub stage: PowerStage,
    pub random: Random,
    pub jitter: u32,
    pub largest_current: f64,
    /// The rotor sensor only counts from power-up on, and has an index.
    pub incremental: bool,
    halls: Halls,
}

impl Truth {
    pub fn three_phase(&self) -> ThreePhaseModel {
        match self.model.winding {
            WindingModel::ThreePhase(winding) => winding,
            WindingModel::Brushed { .. } => unreachable!("a three-phase motor"),
        }
    }

    /// What the settings say before the calibration: R +40 %, flux -10 %, offset 2 degrees off.
    pub fn config(&self, record: Option<&Record>) -> Config {
        let offset = self.offset_degrees() + 2.0;
        let (kind, resistance, inductance) = match self.model.winding {
            WindingModel::Brushed {
                resistance,
                inductance,
                ..
            } => (MotorKind::Brushed, resistance, [inductance; 2]),
            WindingModel::ThreePhase(winding) => (
                MotorKind::ThreePhase,
                winding.resistance,
                winding.inductance,
            ),
        };
        let before = Config {
            kind,
            resistance: 1.4 * resistance,
            inductance,
            torque_constant: 0.9 * self.model.winding.torque_constant(),
            current_limit: self.current_limit,
            bandwidth: 1_000.0,
            gear_ratio: self.model.gear_ratio,
            mounting: Mounting {
                counts_per_turn: self.counts_per_turn(),
                pole_pairs: match self.model.winding {
                    WindingModel::ThreePhase(winding) => winding.pole_pairs.into(),
                    WindingModel::Brushed { .. } => 1,
                },
                offset: ElectricalAngle::from_milli_degrees((offset * 1e3) as i32),
                reversed: self.swapped,
            },
            sensor: RotorSensor::Absolute,
            dead_time: 0.0,
            continuous_current: 10.0,
            periods_per_control: PERIODS,
        };
        match record {
            None => before,
            Some(record) => Config {
                resistance: record.resistance,
                inductance: record.inductance,
                torque_constant: record.torque_constant.expect("the shaft was free"),
                mounting: Mounting {
                    pole_pairs: record.pole_pairs.max(1),
                    offset: record.offset,
                    reversed: record.reversed,
                    ..before.mounting
                },
                ..before
            },
        }
    }

    /// Counts of the rotor sensor per turn of the rotor.
    pub fn counts_per_turn(&self) -> i32 {
        match self.model.winding {
            WindingModel::ThreePhase(winding) if self.halls.is_some() => {
                COUNTS_PER_ELECTRICAL_TURN * i32::from(winding.pole_pairs)
            }
            _ => self.model.encoder_counts as i32,
        }
    }

    /// Electrical angle in the middle of the sensor's count 0, as the node sees it.
    pub fn offset_degrees(&self) -> f64 {
        let WindingModel::ThreePhase(winding) = self.model.winding else {
            return 0.0;
        };
        if let Some(displaced) = self.halls {
            let mean = displaced.iter().sum::<f64>() / 3.0;
            let offset = 60.0 + mean;
            return if self.swapped { -offset } else { offset };
        }
        // The mean of the noise is half a count.
        let middle = if self.sensor_noise { 0.0 } else { 180.0 };
        let half_count =
            middle * f64::from(winding.pole_pairs) / f64::from(self.model.encoder_counts);
        let offset = f64::from(winding.offset_degrees) + half_count;
        if self.swapped { -offset } else { offset }
    }
}

impl Bench {
    pub fn new(truth: &Truth, config: &Config, seed: u64) -> Self {
        let stage = Ratings {
            pwm_hz: STEPS * STAGE.pwm_hz,
            ..STAGE
        };
        let model = MotorModel {
            dead_time: truth.model.dead_time / STEPS as f32,
            ..truth.model
        };
        let mut motor = Motor::new(model, stage, seed).expect("a good model");
        motor.set_load(SUPPLY, 0.0);
        Self {
            truth: *truth,
            motor,
            current_loop: CurrentLoop::new(config, &STAGE).expect("a good configuration"),
            stage: PowerStage::Off,
            random: Random(seed),
            jitter: 0,
            largest_current: 0.0,
            incremental: false,
            halls: Halls::new(),
        }
    }

    pub fn period(&mut self) {
        let truth = &self.truth;
        let mut readings = self.motor.readings();
        let [a, b] = readings.currents.map(|code| f64::from(code) - 32_768.0);
        let second = if truth.swapped { -a - b } else { b };
        let measured = [a, second];
        self.largest_current = measured
            .into_iter()
            .fold(self.largest_current, |largest, code| {
                largest.max(code.abs() / 32_768.0 * f64::from(STAGE.full_scale))
            });
        readings.currents = core::array::from_fn(|phase| {
            let code = measured[phase] * truth.gain[phase] + f64::from(truth.zero[phase]);
            (code.round() + 32_768.0).clamp(0.0, 65_535.0) as u16
        });
        if truth.sensor_noise {
            self.jitter = u32::from(self.random.next() > 0.0);
        }
        readings.rotor = if let Some(displaced) = truth.halls {
            let displaced = displaced.map(|degrees| Angle::from_degrees(degrees as f32));
            self.halls.update(self.motor.halls(displaced))
        } else if self.incremental {
            self.motor.encoder() as u32
        } else {
            (readings.rotor + self.jitter) % truth.model.encoder_counts
        };
        let next = self.current_loop.period(&readings);
        let applied = match self.stage {
            PowerStage::Drive([a, b, c]) if truth.swapped => PowerStage::Drive([a, c, b]),
            stage => stage,
        };
        for _ in 0..STEPS {
            self.motor.integrate(applied);
        }
        self.stage = next;
    }

    /// Runs a calibration to its end; returns its result and its duration, s.
    pub fn calibrate(&mut self, plan: &Plan) -> (Result<Record, Refusal>, f64) {
        let mut calibration = Calibration::new(plan);
        for tick in 0..200_000 {
            if let (Some(count), true) = (self.motor.take_index(), self.incremental) {
                self.current_loop.index_pulse(count as u32);
            }
            let inputs = Inputs {
                encoder: if self.truth.halls.is_some() {
                    self.halls.count()
                } else {
                    self.motor.encoder() + self.jitter as i32
                },
                supply_voltage: SUPPLY,
                measured: self.current_loop.take_measurement(SUPPLY),
            };
            match calibration.tick(&inputs) {
                Progress::Excite(excitation) => self.current_loop.excite(&excitation, SUPPLY),
                Progress::Done(record) => return (Ok(record), f64::from(tick) * 1e-3),
                Progress::Refused(refusal) => return (Err(refusal), f64::from(tick) * 1e-3),
            }
            for _ in 0..PERIODS {
                self.period();
            }
        }
        panic!("the calibration does not end");
    }
}

pub fn plan(truth: &Truth) -> Plan {
    let gear_ratio = truth.model.gear_ratio;
    Plan {
        index: false,
        kind: match truth.model.winding {
            WindingModel::Brushed { .. } => MotorKind::Brushed,
            WindingModel::ThreePhase(_) => MotorKind::ThreePhase,
        },
        ratings: STAGE,
        counts_per_turn: truth.counts_per_turn(),
        gear_ratio,
        current: truth.calibration_current,
        speed: 300.0,
        travel: 12.0,
        torque_constant: 0.9 * truth.model.winding.torque_constant(),
        free_shaft: true,
    }
}

pub fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low + 0.5 * (random.next() + 1.0) * (high - low)
}

/// Drawn so that its logarithm is uniform.
pub fn scaled(random: &mut Random, low: f64, high: f64) -> f64 {
    between(random, low.ln(), high.ln()).exp()
}

/// A random motor. Its numbers are drawn from the time constants and speeds of real motors.
pub fn draw(random: &mut Random, brushed: bool) -> Truth {
    let resistance = scaled(random, 0.03, 5.0);
    let inductance = (resistance * scaled(random, 1.5e-4, 5e-3)).clamp(2e-5, 8e-3);
    let saliency = between(random, 1.0, 1.6);
    let pole_pairs = between(random, 1.0, 24.99) as u8;
    // Electrical no-load speed at the largest voltage.
    let flux = 13.0 / scaled(random, 400.0, 6_000.0);
    let torque_constant = if brushed {
        22.0 / scaled(random, 200.0, 1_000.0)
    } else {
        1.5 * f64::from(pole_pairs) * flux
    };
    let current_limit = (5.0 / resistance).clamp(1.5, 40.0);
    let calibration_current = (between(random, 0.2, 0.6) * current_limit).max(1.0);
    let torque = torque_constant * calibration_current;
    let gear_ratio = scaled(random, 1.0, 100.0);
    // Below 0.15 A the model's dead time is too stiff for its steps.
    let friction = scaled(random, 0.01, 0.6).max(0.15 / calibration_current) * torque;
    // Mechanical time constant of the shorted motor.
    let time_constant = scaled(random, 5e-3, 0.2);
    let counts = scaled(random, 38.0, 600.0) * f64::from(pole_pairs.max(8));
    let winding = if brushed {
        WindingModel::Brushed {
            resistance: resistance as f32,
            inductance: inductance as f32,
            torque_constant: torque_constant as f32,
        }
    } else {
        WindingModel::ThreePhase(ThreePhaseModel {
            resistance: resistance as f32,
            inductance: [inductance as f32, (saliency * inductance) as f32],
            flux: flux as f32,
            pole_pairs,
            offset_degrees: between(random, -180.0, 180.0) as f32,
            cogging_torque: (between(random, 0.0, 0.2) * torque) as f32,
            cogging_periods: 6 * u16::from(pole_pairs),
        })
    };
    Truth {
        model: MotorModel {
            winding,
            rotor_inertia: (time_constant * torque_constant.powi(2) / resistance) as f32,
            gear_ratio: gear_ratio as f32,
            friction_torque: (friction * gear_ratio) as f32,
            brake_torque: 0.0,
            encoder_counts: counts as u32,
            current_noise: between(random, 0.0, 0.1) as f32,
            current_quantum: 64.0 / 2_048.0,
            dead_time: between(random, 0.0, 1e-6) as f32,
        },
        swapped: !brushed && random.next() > 0.0,
        zero: [0; 2].map(|_| between(random, -600.0, 600.0) as i32),
        gain: [0.0; 2].map(|_| between(random, 0.98, 1.02)),
        sensor_noise: random.next() > 0.0,
        halls: None,
        current_limit: current_limit as f32,
        calibration_current: calibration_current as f32,
    }
}
