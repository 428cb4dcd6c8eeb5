//! Finds pole pairs, direction and electrical offset: a current that turns slowly drags the rotor.
//!
//! The rotor is dragged forward, backward and forward again. The first run gives direction and pole
//! pairs. Friction makes the rotor lag, so the offset is the mean of the last two runs. Each run
//! begins with one electrical turn that is not counted.

use super::record::{Quantity, Refusal};
use super::tick::{Hold, Tick, check_at_least, check_at_most};
use crate::constants::{CONTROL_HZ, CONTROL_PERIOD};
use crate::math::trig::atan2;
use crate::motor::current::{Excitation, Frame};
use crate::motor::rotor::{ElectricalAngle, Mounting, Rotor};
use crate::units::Angle;
use core::num::NonZeroU32;

/// Electrical turns per second.
const SPEED: u32 = 4;
/// Time in which the speed changes from one direction to the other, s.
const TURN_ROUND: f32 = 1.0;
const MAXIMUM_POLE_PAIRS: f32 = 64.0;
/// Largest distance of the measured pole pairs from a whole number.
const LARGEST_FRACTION: f32 = 0.25;
/// Fewest counts per electrical turn with which a motor can be commutated.
const FEWEST_COUNTS: f32 = 36.0;
/// Largest lag, rad. Beyond it, the rotor moves in jumps.
const LARGEST_LAG: f32 = 1.0;
/// Part of the allowed travel that the first run uses.
const PART_OF_TRAVEL: f32 = 0.5;

/// State of the step.
#[derive(Clone, Debug)]
pub(super) struct Drag {
    hold: Hold,
    angle: Angle,
    /// Speed, as a fraction of [`SPEED`].
    speed: f32,
    run: usize,
    ticks: u32,
    /// Counts at the start of the run, and how far the first run moved.
    start: i64,
    moved: i64,
    /// Electrical turns of each run.
    turns: u32,
    pole_pairs: i32,
    rotor: Rotor,
    /// Angle of the current minus that of the rotor: first sample, and sum of the differences.
    first: Option<Angle>,
    sum: f32,
    samples: f32,
    backward: Angle,
}

/// Result of the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub pole_pairs: i32,
    pub reversed: bool,
    pub offset: ElectricalAngle,
    pub rotor: Rotor,
    /// Lag by friction, rad.
    pub lag: f32,
}

impl Drag {
    /// Begins with voltages that hold the full current in the direction `angle`.
    pub fn new(hold: Hold, angle: Angle) -> Self {
        Self {
            hold,
            angle,
            speed: 0.0,
            run: 0,
            ticks: 0,
            start: 0,
            moved: 0,
            turns: 0,
            pole_pairs: 1,
            rotor: Rotor::new(mounting(1, 1, false, Angle::ZERO)),
            first: None,
            sum: 0.0,
            samples: 0.0,
            backward: Angle::ZERO,
        }
    }

    /// Runs one tick.
    pub fn tick(
        &mut self,
        tick: &Tick,
        excitation: &mut Excitation,
    ) -> Result<Option<Found>, Refusal> {
        let plan = tick.plan;
        tick.check_travel()?;
        self.hold.update(tick.measured.current, [plan.current, 0.0]);
        let direction = if self.run == 1 { -1.0 } else { 1.0 };
        let rise = 2.0 * CONTROL_PERIOD / TURN_ROUND;
        let before = self.speed;
        self.speed += crate::math::limit(direction - self.speed, rise);
        if before == direction
            && let Some(found) = self.measure(tick)?
        {
            return Ok(Some(found));
        }
        let per_second = 4_294_967_296.0 * SPEED as f32 * self.speed;
        let step = crate::math::to_i32(per_second / plan.ratings.pwm_hz as f32);
        excitation.frame = Frame::Stator {
            angle: self.angle,
            step: Angle::from_bits(step),
        };
        excitation.voltage = self.hold.voltage;
        let periods = plan.periods_per_control() as i32;
        self.angle += Angle::from_bits(step.wrapping_mul(periods));
        Ok(None)
    }

    /// Counts the ticks at full speed, and takes the samples.
    fn measure(&mut self, tick: &Tick) -> Result<Option<Found>, Refusal> {
        let turn = const { NonZeroU32::new(CONTROL_HZ / SPEED).unwrap() };
        self.ticks += 1;
        if self.ticks == turn.get() {
            self.start = tick.travel;
        }
        if self.ticks > turn.get() {
            self.sample(tick);
        }
        let (turns, rest) = (self.ticks / turn, self.ticks % turn);
        if turns < 2 || rest != 0 {
            return Ok(None);
        }
        let moved = tick.travel - self.start;
        let over = match self.run {
            0 => Self::first_run_is_over(tick, turns - 1, moved)?,
            _ => turns > self.turns,
        };
        if !over {
            return Ok(None);
        }
        let first = self.first.unwrap_or_default();
        let mean = first + Angle::from_bits(crate::math::to_i32(self.sum / self.samples));
        self.ticks = 0;
        self.run += 1;
        (self.first, self.sum, self.samples) = (None, 0.0, 0.0);
        if self.run == 1 {
            self.moved = moved;
            self.identify(tick, turns - 1)?;
            return Ok(None);
        }
        // Forward and backward, the rotor turns equally far.
        let missed = tick.plan.turns(moved.abs() - self.moved.abs()).abs();
        let fraction = missed * self.pole_pairs as f32 / self.turns as f32;
        check_at_most(Quantity::PolePairs, fraction, LARGEST_FRACTION)?;
        if self.run == 2 {
            self.backward = mean;
            return Ok(None);
        }
        self.finish(tick, mean).map(Some)
    }

    /// Whether the rotor has turned once, or as far as it may.
    fn first_run_is_over(tick: &Tick, turns: u32, moved: i64) -> Result<bool, Refusal> {
        let plan = tick.plan;
        let turned = plan.turns(moved).abs();
        let slowest = 0.5 * turns as f32 / MAXIMUM_POLE_PAIRS;
        if turns >= 2 {
            check_at_least(Quantity::RotorPerElectrical, turned, slowest)?;
        }
        let goal = crate::math::min(0.98, PART_OF_TRAVEL * plan.travel);
        Ok(turned >= goal || turns as f32 >= 2.0 * MAXIMUM_POLE_PAIRS)
    }

    fn sample(&mut self, tick: &Tick) {
        let [d, q] = tick.measured.current;
        let current = tick.measured.angle + Angle::from_radians(atan2(q, d));
        let ahead = current - self.rotor.angle(tick.measured.rotor).0;
        let first = *self.first.get_or_insert(ahead);
        self.sum += (ahead - first).to_bits() as f32;
        self.samples += 1.0;
    }

    /// Computes pole pairs and direction from the first run.
    fn identify(&mut self, tick: &Tick, turns: u32) -> Result<(), Refusal> {
        let counts = tick.plan.counts_per_turn;
        let ratio = turns as f32 / tick.plan.turns(self.moved).abs();
        let pole_pairs = crate::math::to_i32(ratio + 0.5);
        let fraction = (ratio - pole_pairs as f32).abs();
        check_at_most(Quantity::PolePairs, fraction, LARGEST_FRACTION)?;
        let per_turn = counts as f32 / ratio;
        check_at_least(Quantity::SensorCounts, per_turn, FEWEST_COUNTS)?;
        self.turns = turns;
        self.pole_pairs = pole_pairs;
        self.rotor = Rotor::new(mounting(counts, pole_pairs, self.moved < 0, Angle::ZERO));
        Ok(())
    }

    fn finish(&self, tick: &Tick, forward: Angle) -> Result<Found, Refusal> {
        let apart = (forward - self.backward).to_bits();
        let lag = apart as f32 * (0.5 * core::f32::consts::TAU / 4_294_967_296.0);
        check_at_most(Quantity::Lag, lag.abs(), LARGEST_LAG)?;
        let offset = self.backward + Angle::from_bits(apart / 2);
        let reversed = self.moved < 0;
        let counts = tick.plan.counts_per_turn;
        Ok(Found {
            pole_pairs: self.pole_pairs,
            reversed,
            offset: ElectricalAngle(offset),
            rotor: Rotor::new(mounting(counts, self.pole_pairs, reversed, offset)),
            lag,
        })
    }
}

fn mounting(counts_per_turn: i32, pole_pairs: i32, reversed: bool, offset: Angle) -> Mounting {
    Mounting {
        counts_per_turn,
        pole_pairs,
        offset: ElectricalAngle(offset),
        reversed,
    }
}
