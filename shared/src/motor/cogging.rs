//! Cogging torque of a three-phase motor: the current that cancels it, and the search for it.
//!
//! The teeth of the stator attract the magnets. The torque repeats a whole number of times in an
//! electrical turn: the least common multiple of slots and poles, divided by the pole pairs. So the
//! electrical angle shows its phase, also after an alignment.
//!
//! The search turns the shaft at a constant velocity and measures the ripple of the velocity that
//! has the period of the cogging: without a current, and with a known one. Both are linear, so the
//! ripple and its change give the current that cancels it, whatever inertia and control loops do.

use super::rotor::ElectricalAngle;
use crate::math::{Turns, sin_cos};
use crate::units::Angle;

/// Current that cancels a torque, A: in phase with the cosine and with the sine of the cogging's
/// angle.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Wave {
    /// Part with the cosine.
    pub cosine: f32,
    /// Part with the sine.
    pub sine: f32,
}

impl Wave {
    fn plus(self, other: Self) -> Self {
        Self {
            cosine: self.cosine + other.cosine,
            sine: self.sine + other.sine,
        }
    }

    fn minus(self, other: Self) -> Self {
        Self {
            cosine: self.cosine - other.cosine,
            sine: self.sine - other.sine,
        }
    }

    /// Product of complex numbers.
    fn times(self, other: Self) -> Self {
        Self {
            cosine: self.cosine * other.cosine - self.sine * other.sine,
            sine: self.cosine * other.sine + self.sine * other.cosine,
        }
    }

    fn conjugate(self) -> Self {
        Self {
            sine: -self.sine,
            ..self
        }
    }

    fn scaled(self, factor: f32) -> Self {
        Self {
            cosine: self.cosine * factor,
            sine: self.sine * factor,
        }
    }

    /// Square of the amplitude.
    pub fn square(self) -> f32 {
        self.cosine * self.cosine + self.sine * self.sine
    }
}

/// Control periods for which a velocity settles after a change of the current, and in which the
/// ripple is measured.
const SETTLE: u32 = 500;
const MEASURED: u32 = 4_000;
/// Runs with a current that follows from the runs before.
const CORRECTIONS: u32 = 3;

/// What the search does next.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Progress {
    /// Goes on with this current.
    Apply(Wave),
    /// The current, and the amplitude of the ripple with it, divided by the one without it.
    Done(Wave, f32),
    /// The test current changed the ripple too little, or the ripple did not shrink.
    Failed,
}

/// The search, at a constant velocity.
#[derive(Clone, Debug)]
pub struct Search {
    periods: i32,
    test: f32,
    run: u32,
    ticks: u32,
    last: Option<Turns>,
    sum: Wave,
    /// Ripple without a current.
    first: Wave,
    /// Sum of the currents that the runs after that with the test current expect to cancel it.
    expected: Wave,
    current: Wave,
    best: (Wave, f32),
}

impl Search {
    /// Creates the search for a torque with this number of periods in an electrical turn, with this
    /// test current, A.
    pub fn new(periods: i32, test: f32) -> Self {
        Self {
            periods,
            test,
            run: 0,
            ticks: 0,
            last: None,
            sum: Wave::default(),
            first: Wave::default(),
            expected: Wave::default(),
            current: Wave::default(),
            best: (Wave::default(), f32::INFINITY),
        }
    }

    /// Runs one control period at this angle of the rotor and this position of the output
    /// shaft.
    pub fn tick(&mut self, angle: ElectricalAngle, position: Turns) -> Progress {
        let last = self.last.replace(position).unwrap_or(position);
        self.ticks += 1;
        if self.ticks > SETTLE {
            let phase = angle.0.to_bits().wrapping_mul(self.periods);
            let (sin, cos) = sin_cos(Angle::from_bits(phase));
            let moved = (position - last).to_bits() as f32;
            self.sum.cosine += moved * cos;
            self.sum.sine += moved * sin;
        }
        if self.ticks < SETTLE + MEASURED {
            return Progress::Apply(self.current);
        }
        let ripple = core::mem::take(&mut self.sum);
        self.ticks = 0;
        self.run += 1;
        let (square, used) = (ripple.square(), self.current);
        if square < self.best.1 {
            self.best = (used, square);
        }
        if self.run == 1 {
            self.first = ripple;
            self.current = Wave {
                cosine: self.test,
                sine: 0.0,
            };
        } else if self.run < 2 + CORRECTIONS {
            // ripple = first + response * current. The response is that of the whole current: what
            // a small change of it changes is lost in noise.
            let response_times_square = ripple.minus(self.first).times(used.conjugate());
            let divisor = response_times_square.square();
            if !(divisor > 0.0) {
                return Progress::Failed;
            }
            let change = ripple
                .times(response_times_square.conjugate())
                .scaled(used.square() / divisor);
            self.current = used.minus(change);
            if self.run > 2 {
                self.expected = self.expected.plus(self.current);
                self.current = self.expected.scaled(1.0 / (self.run - 2) as f32);
            }
        } else {
            let (wave, square) = self.best;
            let left = crate::math::sqrt(square / self.first.square());
            return if left < 0.5 {
                Progress::Done(wave, left)
            } else {
                Progress::Failed
            };
        }
        Progress::Apply(self.current)
    }
}
