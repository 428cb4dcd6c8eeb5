//! The state machine of a calibration. It runs one step after the other and keeps what they find.

use super::Plan;
use super::drag::{self, Drag};
use super::inductance::{Inductance, Response};
use super::record::{Quantity, Record, Refusal, Residuals};
use super::resistance::{self, Resistance};
use super::spin::{self, Axes, Known, Spin};
use super::swing::{self, Swing};
use super::tick::{Tick, check, check_at_least, check_at_most};
use super::zero::{self, Zero};
use crate::constants::CONTROL_HZ;
use crate::motor::bridge::{CurrentSensing, MAX_DUTY};
use crate::motor::current::{
    Excitation, Frame, MIN_SUPPLY_VOLTAGE, Measurement, MotorKind, VOLTAGE_FULL_SCALE,
};
use crate::motor::rotor::{ElectricalAngle, Mounting, Rotor};
use crate::units::Angle;

/// Readings of one control period.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Inputs {
    /// Wrapping counter of the rotor's encoder.
    pub encoder: i32,
    /// Supply voltage, V.
    pub supply_voltage: f32,
    /// Measurement of the excitation; `None` if no sample was taken.
    pub measured: Option<Measurement>,
}

/// Step under way. Object 0x2051 shows its number.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Step {
    /// Offsets of the current converter.
    Zero = 1,
    /// Resistance of a three-phase motor.
    Resistance = 2,
    /// Pole pairs, direction and electrical offset.
    Drag = 3,
    /// Inductances.
    Inductance = 4,
    /// Flux linkage of a three-phase motor.
    Spin = 5,
    /// Resistance and torque constant of a brushed motor.
    Swing = 6,
}

/// Result of a tick.
#[derive(Clone, Copy, Debug)]
pub enum Progress {
    /// Excite the motor in this way until the next tick.
    Excite(Excitation),
    /// All values were found. The bridge must be off from now on.
    Done(Record),
    /// The calibration has ended without a result. The bridge must be off from now on.
    Refused(Refusal),
}

/// Smallest current of a calibration, as a fraction of the board's full scale. Below it, noise and
/// the steps of the converter count.
const SMALLEST_CURRENT: f32 = 0.01;
/// Longest time of a step, s. Only faulty sensors keep a step longer.
const TIMEOUT_S: u32 = 120;

#[derive(Clone, Debug)]
enum State {
    Zero(Zero),
    Resistance(Resistance),
    Drag(Drag),
    Inductance(Inductance),
    Spin(Spin),
    Swing(Swing),
    Ended(Result<Record, Refusal>),
}

/// A calibration under way.
#[derive(Clone, Debug)]
pub struct Calibration {
    plan: Plan,
    state: State,
    /// Ticks of the present step.
    ticks: u32,
    /// Encoder at the last tick, and counts since the start.
    encoder: Option<i32>,
    travel: i64,
    /// Count of the rotor sensor at the newest pulse of its index.
    index: Option<u32>,
    record: Record,
    rotor: Rotor,
    responses: [Response; 2],
    /// Back-EMF of a brushed motor, which needs the resistance to be evaluated.
    spun: Option<spin::Found>,
}

impl Calibration {
    /// Begins a calibration. The drive must be disarmed.
    pub fn new(plan: &Plan) -> Self {
        Self {
            plan: *plan,
            state: State::Zero(Zero::default()),
            ticks: 0,
            encoder: None,
            travel: 0,
            index: None,
            record: Record {
                sensing: CurrentSensing {
                    zero: [zero::LOWEST; 2],
                    ..CurrentSensing::default()
                },
                resistance: 0.0,
                inductance: [0.0; 2],
                pole_pairs: 0,
                reversed: false,
                offset: ElectricalAngle::default(),
                torque_constant: None,
                residuals: Residuals::default(),
            },
            rotor: Rotor::new(Mounting {
                counts_per_turn: plan.counts_per_turn,
                pole_pairs: 1,
                offset: ElectricalAngle::default(),
                reversed: false,
            }),
            responses: [Response::default(); 2],
            spun: None,
        }
    }

    /// Returns the step under way; `None` after the end.
    pub fn step(&self) -> Option<Step> {
        match self.state {
            State::Zero(_) => Some(Step::Zero),
            State::Resistance(_) => Some(Step::Resistance),
            State::Drag(_) => Some(Step::Drag),
            State::Inductance(_) => Some(Step::Inductance),
            State::Spin(_) => Some(Step::Spin),
            State::Swing(_) => Some(Step::Swing),
            State::Ended(_) => None,
        }
    }

    /// Runs one control period.
    pub fn tick(&mut self, inputs: &Inputs) -> Progress {
        let mut excitation = Excitation::default();
        if let Err(refusal) = self.advance(inputs, &mut excitation) {
            self.state = State::Ended(Err(refusal));
        }
        if let State::Zero(step) = &self.state {
            excitation.open = !step.is_live();
            if let Some(zero) = step.of_open_bridge() {
                self.record.sensing.zero = zero;
            }
        }
        excitation.sensing = self.record.sensing;
        match self.state {
            State::Ended(Ok(record)) => Progress::Done(record),
            State::Ended(Err(refusal)) => Progress::Refused(refusal),
            _ => Progress::Excite(excitation),
        }
    }

    /// Runs one tick of the present step, which changes the excitation. The next step excites the
    /// motor from the next tick on.
    #[inline(never)] // a calibration is smaller in two parts
    fn advance(&mut self, inputs: &Inputs, excitation: &mut Excitation) -> Result<(), Refusal> {
        let Some(step) = self.step() else {
            return Ok(());
        };
        let moved = inputs
            .encoder
            .wrapping_sub(self.encoder.unwrap_or(inputs.encoder));
        self.encoder = Some(inputs.encoder);
        self.travel += i64::from(moved);
        let measured = inputs.measured.unwrap_or_default();
        let plan = self.plan;
        let reach = match plan.kind {
            MotorKind::Brushed => MAX_DUTY,
            MotorKind::ThreePhase => MAX_DUTY / 1.732_050_8,
        };
        let tick = Tick {
            plan: &plan,
            step,
            limit: 0.95 * reach * inputs.supply_voltage,
            measured,
            moved,
            travel: self.travel,
        };
        let supply = inputs.supply_voltage;
        check_at_least(Quantity::SupplyVoltage, supply, MIN_SUPPLY_VOLTAGE)?;
        check_at_most(Quantity::SupplyVoltage, supply, VOLTAGE_FULL_SCALE)?;
        let least = SMALLEST_CURRENT * plan.ratings.full_scale;
        check_at_least(Quantity::Current, plan.current, least)?;
        // Half as much again as the steps use. The first step does not know the zero yet.
        if step != Step::Zero {
            let [d, q] = measured.current;
            let current = crate::math::sqrt(d * d + q * q);
            check_at_most(
                Quantity::Current,
                current,
                1.5 * plan.current + noise(&plan),
            )?;
        }
        self.index = measured.index;
        self.ticks += 1;
        if self.ticks > TIMEOUT_S * CONTROL_HZ {
            return Err(tick.timeout(TIMEOUT_S * CONTROL_HZ));
        }
        if inputs.measured.is_none() {
            return Ok(());
        }
        macro_rules! run {
            ($found:expr, $finish:ident) => {
                match $found? {
                    None => return Ok(()),
                    Some(found) => self.$finish(found)?,
                }
            };
        }
        match &mut self.state {
            State::Zero(step) => run!(step.tick(&tick), after_zero),
            State::Resistance(step) => run!(step.tick(&tick, excitation), after_resistance),
            State::Drag(step) => run!(step.tick(&tick, excitation), after_drag),
            State::Inductance(step) => run!(step.tick(&tick, excitation), after_inductance),
            State::Spin(step) => run!(step.tick(&tick, excitation), after_spin),
            State::Swing(step) => run!(step.tick(&tick, excitation), after_swing),
            State::Ended(_) => {}
        }
        self.ticks = 0;
        Ok(())
    }

    #[allow(clippy::unnecessary_wraps)] // every step ends with such a function
    fn after_zero(&mut self, zero: [i32; 2]) -> Result<(), Refusal> {
        self.record.sensing.zero = zero;
        self.state = match self.plan.kind {
            MotorKind::ThreePhase => State::Resistance(Resistance::default()),
            MotorKind::Brushed => {
                let frame = Frame::Stator {
                    angle: Angle::ZERO,
                    step: Angle::ZERO,
                };
                State::Inductance(Inductance::new(frame, 1))
            }
        };
        Ok(())
    }

    #[allow(clippy::unnecessary_wraps)]
    fn after_resistance(&mut self, found: resistance::Found) -> Result<(), Refusal> {
        self.record.sensing.gain = found.gain;
        self.record.resistance = found.resistance;
        self.record.residuals.resistance = found.residual;
        self.state = State::Drag(Drag::new(found.hold, Angle::from_degrees(-120.0)));
        Ok(())
    }

    #[allow(clippy::unnecessary_wraps)]
    fn after_drag(&mut self, found: drag::Found) -> Result<(), Refusal> {
        self.record.pole_pairs = found.pole_pairs;
        self.record.reversed = found.reversed;
        self.record.offset = found.offset;
        self.record.residuals.lag = found.lag.abs();
        self.rotor = found.rotor;
        let frame = Frame::Rotor {
            rotor: found.rotor,
            lead: Angle::ZERO,
        };
        self.state = State::Inductance(Inductance::new(frame, 2));
        Ok(())
    }

    fn after_inductance(&mut self, responses: [Response; 2]) -> Result<(), Refusal> {
        self.responses = responses;
        let free = self.plan.free_shaft;
        if self.plan.kind == MotorKind::Brushed {
            self.state = if free {
                State::Spin(Spin::new(Known {
                    axes: Axes::Winding,
                    electrical_per_rotor: 1.0,
                    inductance: [0.0; 2],
                }))
            } else {
                self.swing(self.plan.torque_constant)
            };
            return Ok(());
        }
        let resistance = self.record.resistance;
        for (found, response) in self.record.inductance.iter_mut().zip(responses) {
            *found = response.inductance(resistance)?;
        }
        let direction = self.rotor.direction();
        self.state = if free {
            State::Spin(Spin::new(Known {
                axes: Axes::Rotor(self.rotor),
                electrical_per_rotor: (self.record.pole_pairs * direction) as f32,
                inductance: self.record.inductance,
            }))
        } else {
            return self.end(None);
        };
        Ok(())
    }

    fn swing(&self, torque_constant: f32) -> State {
        State::Swing(Swing::new(self.responses[0].rough(), torque_constant))
    }

    fn after_spin(&mut self, found: spin::Found) -> Result<(), Refusal> {
        if self.plan.kind == MotorKind::Brushed {
            self.spun = Some(found);
            // The travel of the next step counts from here.
            self.travel = 0;
            // The resistance is not known yet; friction needs nearly the same current.
            let (torque_constant, _) = found.flux(0.0)?;
            self.state = self.swing(torque_constant);
            return Ok(());
        }
        let (flux, residual) = found.flux(self.record.resistance)?;
        let torque_constant = 1.5 * self.record.pole_pairs as f32 * flux;
        self.end(Some((torque_constant, residual)))
    }

    fn after_swing(&mut self, found: swing::Found) -> Result<(), Refusal> {
        let inductance = self.responses[0].inductance(found.resistance)?;
        self.record.resistance = found.resistance;
        self.record.inductance = [inductance; 2];
        self.record.residuals.resistance = found.residual;
        let torque_constant = match self.spun {
            Some(spun) => Some(spun.flux(found.resistance)?),
            None => None,
        };
        self.end(torque_constant)
    }

    /// Ends with the torque constant and its residual, if they were measured.
    fn end(&mut self, torque_constant: Option<(f32, f32)>) -> Result<(), Refusal> {
        if let Some((value, residual)) = torque_constant {
            check(value > 0.0, Quantity::BackEmf, value, 0.0)?;
            self.record.torque_constant = Some(value);
            self.record.residuals.torque_constant = residual;
        }
        if self.plan.index && self.plan.kind == MotorKind::ThreePhase {
            let pulses = if self.index.is_some() { 1.0 } else { 0.0 };
            check_at_least(Quantity::IndexPulses, pulses, 1.0)?;
            self.record.offset = self.rotor.angle(self.index.unwrap_or_default());
        }
        self.state = State::Ended(Ok(self.record));
        Ok(())
    }
}

/// Current that is not told from noise: half a percent of the converter's range, A.
fn noise(plan: &Plan) -> f32 {
    5e-3 * plan.ratings.full_scale
}
