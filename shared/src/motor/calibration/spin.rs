//! Measures the back-EMF: the shaft turns freely at two speeds in each direction, and the voltage
//! rises with the speed by the flux linkage (brushed: by the torque constant).
//!
//! Friction needs the same current at both speeds, so resistance and dead time cancel.

use super::record::{Quantity, Refusal};
use super::tick::{Mean, Tick, check_at_least, check_at_most};
use crate::constants::CONTROL_PERIOD;
use crate::motor::current::{Excitation, Frame};
use crate::motor::rotor::Rotor;
use crate::units::Angle;

/// Largest voltage, as a fraction of the bridge's.
const LARGEST: f32 = 0.6;
/// Time in which the voltage would rise to the bridge's, s.
const RISE: f32 = 3.0;
/// Ticks in which the speed is compared, and its largest change meanwhile, as a fraction.
const SETTLE: u32 = 400;
const STEADY: f32 = 1e-3;
const TICKS: u32 = 500;
/// Ticks after which a level must have been reached.
const TIMEOUT: u32 = 20_000;
/// Largest electrical angle per PWM period, rad.
const LARGEST_STEP: f32 = 0.1;
/// How far the speed may exceed its bound before the calibration ends.
const EXCESS: f32 = 1.3;
/// Largest difference of both directions, divided by the mean.
const LARGEST_DIFFERENCE: f32 = 0.05;
/// Smallest difference of the counts at both speeds. It bounds what the steps of the encoder cost.
const FEWEST_COUNTS: f32 = 400.0;

/// What the step must know.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    /// Axes in which the motor is driven.
    pub axes: Axes,
    /// Pole pairs, with the sign of the direction; 1 for a brushed motor.
    pub electrical_per_rotor: f32,
    /// Inductances of the axes d and q, henry; 0 for a brushed motor, whose axes do not couple.
    pub inductance: [f32; 2],
}

/// Axes in which the motor is driven.
#[derive(Clone, Copy, Debug)]
pub(super) enum Axes {
    /// Winding of a brushed motor, which is the component d.
    Winding,
    /// Axis q of a three-phase motor.
    Rotor(Rotor),
}

/// State of the step.
#[derive(Clone, Debug)]
pub(super) struct Spin {
    known: Known,
    /// Voltage in q, and the voltage of the present level.
    voltage: f32,
    goal: f32,
    level: usize,
    reached: bool,
    ticks: u32,
    /// Counts in the last ticks, and in those before.
    moved: [i32; 2],
    steady: bool,
    /// Electrical speed, rad/s, smoothed.
    speed: f32,
    mean: Mean,
    /// Means at the high speed, and differences between both speeds in each direction.
    high: Point,
    found: [Point; 2],
}

/// Means at one speed, or their differences.
#[derive(Clone, Copy, Debug, Default)]
struct Point {
    /// Voltage without that of the axes' coupling, V.
    voltage: f32,
    /// Current that makes the torque, A.
    current: f32,
    /// Electrical speed, rad/s.
    speed: f32,
}

/// Result of the step: what changes between the speeds, in each direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found([Point; 2]);

impl Found {
    /// Returns the flux linkage, V s (brushed: torque constant, N m/A), and the difference of both
    /// directions divided by their mean. The resistance is in ohm.
    pub fn flux(&self, resistance: f32) -> Result<(f32, f32), Refusal> {
        let [forward, backward] = self
            .0
            .map(|change| (change.voltage - resistance * change.current) / change.speed);
        let flux = 0.5 * (forward + backward);
        let residual = (forward - backward).abs() / flux.abs();
        check_at_most(Quantity::TorqueConstant, residual, LARGEST_DIFFERENCE)?;
        Ok((flux, residual))
    }
}

impl Spin {
    pub fn new(known: Known) -> Self {
        Self {
            known,
            voltage: 0.0,
            goal: 0.0,
            level: 0,
            reached: false,
            ticks: 0,
            moved: [0; 2],
            steady: false,
            speed: 0.0,
            mean: Mean::default(),
            high: Point::default(),
            found: [Point::default(); 2],
        }
    }

    /// Runs one tick.
    pub fn tick(
        &mut self,
        tick: &Tick,
        excitation: &mut Excitation,
    ) -> Result<Option<Found>, Refusal> {
        let plan = tick.plan;
        let per_count = self.known.electrical_per_rotor * core::f32::consts::TAU
            / (plan.counts_per_turn as f32 * CONTROL_PERIOD);
        self.speed += (tick.moved as f32 * per_count - self.speed) * (1.0 / 16.0);
        let pole_pairs = self.known.electrical_per_rotor.abs();
        let bound = crate::math::min(
            plan.speed,
            LARGEST_STEP * plan.ratings.pwm_hz as f32 / pole_pairs,
        );
        let speed = self.speed.abs() / pole_pairs;
        check_at_most(Quantity::Speed, speed, EXCESS * bound)?;
        self.ticks += 1;
        if self.steady {
            self.mean.add(tick);
            if self.ticks == TICKS {
                self.end_level(tick, per_count)?;
            }
        } else if self.reached {
            self.settle(tick)?;
        } else {
            self.approach(tick, speed >= bound)?;
        }
        if self.level == 5 && self.reached {
            return Ok(Some(Found(self.found)));
        }
        self.excite(tick, excitation);
        Ok(None)
    }

    fn excite(&self, tick: &Tick, excitation: &mut Excitation) {
        match self.known.axes {
            Axes::Winding => excitation.voltage[0] = self.voltage,
            Axes::Rotor(rotor) => {
                let lead = 1.5 * self.speed / tick.plan.ratings.pwm_hz as f32;
                let lead = Angle::from_radians(lead);
                // Cancels the coupling, so that the current in d stays small.
                let coupled = -self.speed * self.known.inductance[1] * tick.measured.current[1];
                excitation.frame = Frame::Rotor { rotor, lead };
                excitation.voltage = [coupled, self.voltage];
            }
        }
    }

    /// Returns the driven component and the other one.
    fn driven(&self, [d, q]: [f32; 2]) -> [f32; 2] {
        match self.known.axes {
            Axes::Winding => [d, q],
            Axes::Rotor(_) => [q, d],
        }
    }

    /// Changes the voltage towards that of the level while the current allows it. A high level
    /// also ends where the speed reaches its bound.
    fn approach(&mut self, tick: &Tick, fast: bool) -> Result<(), Refusal> {
        if self.ticks > TIMEOUT {
            return Err(tick.timeout(TIMEOUT));
        }
        let goal = match self.level {
            0 => LARGEST * tick.limit,
            2 => -LARGEST * tick.limit,
            _ => self.goal,
        };
        let [q, d] = self.driven(tick.measured.current);
        let step = tick.limit * CONTROL_PERIOD / RISE;
        let change = crate::math::limit(goal - self.voltage, step);
        // A change that reduces the current is always allowed.
        let allowed = d * d + q * q < tick.plan.current * tick.plan.current || q * change < 0.0;
        if allowed {
            self.voltage += change;
        }
        let high = self.level == 0 || self.level == 2;
        let right_way = self.voltage * goal > 0.0 && self.speed * goal > 0.0;
        if self.voltage == goal || high && fast && right_way {
            self.reached = true;
            self.ticks = 0;
        }
        Ok(())
    }

    /// Waits until the speed is steady: only then friction needs the same current at both speeds.
    fn settle(&mut self, tick: &Tick) -> Result<(), Refusal> {
        let [now, before] = &mut self.moved;
        *now += tick.moved;
        if !self.ticks.is_multiple_of(SETTLE) {
            return Ok(());
        }
        let change = (*now - *before).abs() as f32;
        // A count is the noise of the sensor.
        let steady = change <= STEADY * now.abs() as f32 + 1.0;
        self.moved = [0, *now];
        if steady && self.ticks > SETTLE {
            self.steady = true;
            self.ticks = 0;
        } else if self.ticks > TIMEOUT {
            return Err(tick.timeout(TIMEOUT));
        }
        Ok(())
    }

    fn end_level(&mut self, tick: &Tick, per_count: f32) -> Result<(), Refusal> {
        let mean = core::mem::take(&mut self.mean).result();
        let [current, across] = self.driven(mean.current);
        let speed = mean.moved * per_count;
        let point = Point {
            voltage: self.driven(mean.voltage)[0] - speed * self.known.inductance[0] * across,
            current,
            speed,
        };
        self.ticks = 0;
        self.reached = false;
        self.steady = false;
        self.level += 1;
        if self.level % 2 == 1 {
            self.high = point;
            self.goal = 0.5 * self.voltage;
            return Ok(());
        }
        let high = self.high;
        let change = Point {
            voltage: high.voltage - point.voltage,
            current: high.current - point.current,
            speed: high.speed - point.speed,
        };
        self.check_turning(tick, &change)?;
        if let Some(found) = self.found.get_mut(self.level / 2 - 1) {
            *found = change;
        }
        self.goal = 0.0;
        if self.level == 4 {
            // Down to standstill before the bridge opens.
            self.level = 5;
        }
        Ok(())
    }

    /// Refuses a shaft that does not turn as the voltage says: a blocked one, or one that turns the
    /// other way.
    fn check_turning(&self, tick: &Tick, change: &Point) -> Result<(), Refusal> {
        let pole_pairs = self.known.electrical_per_rotor.abs();
        let turns = FEWEST_COUNTS / tick.plan.counts_per_turn as f32;
        let seconds = TICKS as f32 * CONTROL_PERIOD;
        let slowest = turns * core::f32::consts::TAU / seconds;
        let speed = change.speed * f32::copysign(1.0, change.voltage) / pole_pairs;
        check_at_least(Quantity::Speed, speed, slowest)
    }
}
