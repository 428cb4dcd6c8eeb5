//! The limits in force: in operation, while homing, in bench mode, and while homing in bench mode.
//!
//! Velocity and current are limited inside the loops. So each envelope (a set of limits) has loops
//! of its own, which are prepared at start. A change of the envelope hands over the integral, so
//! that the motor's current does not jump.

use super::Axle;
use super::watches::Stall;
use crate::bus::cia402::{State, mode};
use crate::constants::CONTROL_PERIOD;
use crate::math::{Bound, limit};
use crate::motor::cascade::{Cascade, Gains};
use crate::motor::profile::Limits;
use crate::settings::{Setting, Settings};

/// Limits of one kind of operation, with the loops that keep them.
#[derive(Clone, Debug)]
pub(super) struct Envelope {
    pub limits: Limits,
    /// Largest current, A.
    pub current_limit: f32,
    /// Thresholds of a blocked motor.
    pub stall: Stall,
    pub cascade: Cascade,
    /// Bounds of the cascade: the current limit, and the current with which an axle should be able
    /// to hold its position after a stop.
    pub full: Bound,
    pub hold: Bound,
}

/// All envelopes, and the index of the one in force.
#[derive(Clone, Debug)]
pub(super) struct Envelopes {
    prepared: [Envelope; 4],
    selected: usize,
}

/// Velocity limit while homing, divided by the homing speed. The excess is for corrections by the
/// position loop.
const HOMING_MARGIN: f32 = 1.25;

impl Envelope {
    fn new(settings: &Settings, velocity: f32, current: f32) -> Self {
        let cascade = Cascade::new(&Gains {
            position: settings.si(Setting::PositionGain),
            velocity: settings.si(Setting::VelocityGain),
            integral_time: settings.si(Setting::VelocityIntegralTime),
            acceleration: settings.si(Setting::AccelerationFeedForward),
            velocity_limit: velocity,
            current_limit: current,
            period: CONTROL_PERIOD,
        });
        let hold_current = settings.si(Setting::HoldCurrent);
        Self {
            limits: Limits {
                velocity,
                acceleration: settings.si(Setting::AccelerationLimit),
            },
            current_limit: current,
            stall: Stall {
                pushing: 0.9 * current,
                standing: 0.01 * velocity,
            },
            full: cascade.bound(current),
            hold: cascade.bound(limit(hold_current, current)),
            cascade,
        }
    }
}

impl Envelopes {
    /// Creates the envelopes of these settings, and returns a copy of the selected one, that of
    /// operation.
    pub fn new(settings: &Settings) -> (Self, Envelope) {
        let prepared = Self::prepare(settings);
        let operation = prepared[0].clone();
        let envelopes = Self {
            prepared,
            selected: 0,
        };
        (envelopes, operation)
    }

    /// Takes over the gains and limits of these settings. The envelope in force keeps its integral.
    pub fn retune(&mut self, settings: &Settings, in_force: &mut Envelope) {
        self.prepared = Self::prepare(settings);
        self.put(self.selected, in_force);
    }

    #[inline(never)] // an inlined copy is longer than a call
    fn prepare(settings: &Settings) -> [Envelope; 4] {
        let velocity = settings.si(Setting::VelocityLimit);
        let current = settings.si(Setting::CurrentLimit);
        core::array::from_fn(|index| {
            let (mut velocity, mut current) = (velocity, current);
            if index & HOMING != 0 {
                let speed = HOMING_MARGIN * settings.si(Setting::HomingSpeed);
                velocity = limit(speed, velocity);
                current = limit(settings.si(Setting::HomingCurrent), current);
            }
            if index & BENCH != 0 {
                velocity = limit(settings.si(Setting::BenchSpeed), velocity);
                current = limit(settings.si(Setting::BenchCurrent), current);
            }
            Envelope::new(settings, velocity, current)
        })
    }

    /// Returns whether the envelope in force is one of bench mode.
    fn bench(&self) -> bool {
        self.selected & BENCH != 0
    }

    /// Returns whether the envelope in force is one of homing.
    pub fn homing(&self) -> bool {
        self.selected & HOMING != 0
    }

    /// Returns the velocity limit of homing, rad/s.
    fn homing_velocity(&self) -> f32 {
        self.prepared[HOMING].limits.velocity
    }

    /// Puts the envelope of this operation in force.
    pub fn select(&mut self, homing: bool, bench: bool, in_force: &mut Envelope) {
        let index = usize::from(homing) * HOMING + usize::from(bench) * BENCH;
        if index != self.selected {
            self.put(index, in_force);
        }
    }

    fn put(&mut self, index: usize, in_force: &mut Envelope) {
        let Some(prepared) = self.prepared.get(index) else {
            return; // does not happen: two bits are at most 3
        };
        let mut next = prepared.clone();
        next.cascade.take_over(&in_force.cascade, next.full);
        *in_force = next;
        self.selected = index;
    }
}

/// Bits of an envelope's index.
const HOMING: usize = 1;
const BENCH: usize = 2;

impl Axle {
    /// Selects the envelope by the mode and by bench mode. A drive that holds does not home,
    /// whatever its mode is. If it holds since bench mode has ended, it keeps the limits of bench
    /// mode. An axle that is too fast for homing decelerates with the limits of operation.
    pub(super) fn select_envelope(&mut self) {
        let slow = self.velocity().abs() <= self.envelopes.homing_velocity();
        let holds = self.state == State::QuickStopActive;
        let homing = self.mode == mode::HOMING && slow && !holds;
        let bench = self.authority.bench() || holds && self.envelopes.bench();
        self.envelopes.select(homing, bench, &mut self.envelope);
        self.offset.clear();
    }
}
