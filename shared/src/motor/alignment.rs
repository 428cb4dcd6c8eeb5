//! Finds the electrical angle of a three-phase rotor whose sensor only counts, or checks that of an
//! absolute sensor: a current that stands, and then turns slowly, drags the rotor along.
//!
//! The field first stands at 90 degrees and then goes to 0, so that the rotor follows it wherever
//! it stood. Then the field turns by 180 degrees and back. Friction makes the rotor lag, so the
//! angle is the mean of both directions. A rotor that does not follow, or whose sensor counts the
//! wrong way, does not stay at the same distance from the field: the alignment fails.
//!
//! While the field stands at 90 degrees, the voltage of the current shows the resistance. A motor
//! whose resistance is not that of the settings is another motor, or has a short.
//!
//! The field is set back by a part of the rotor's speed, because nothing else damps a rotor that
//! swings in a constant current.

use super::rotor::{ElectricalAngle, RotorSensor};
use crate::constants::CONTROL_PERIOD;
use crate::math::{Bound, Turns};
use crate::settings::{Setting, Settings};
use crate::units::Angle;

/// Control periods of the stages: the current rises at 90 degrees, the rotor settles, the field
/// goes to 0, the rotor settles, the field turns by 180 degrees, and back.
const RISE: i32 = ticks(0.1);
const SETTLE: i32 = ticks(0.15);
const TURN: i32 = ticks(0.3);
const AT_ZERO: i32 = RISE + SETTLE + TURN / 2;
const FORWARD: i32 = AT_ZERO + SETTLE;
const BACKWARD: i32 = FORWARD + TURN;
const END: i32 = BACKWARD + TURN;
/// Part of each turn, at its end, in which the rotor's angle is measured: 120 degrees. It holds
/// whole periods of the cogging torque of most motors.
const MEASURED: i32 = TURN * 2 / 3;

/// Angle by which the field turns in a control period.
const STEP: i32 = (1 << 30) / (TURN / 2);
/// Largest change of the distance from the field to the rotor while it is measured in one
/// direction: 45 degrees, and 90 degrees with Hall sensors, whose angle may jump by half a sector
/// and more. A rotor that stands changes it by 120 degrees.
const SPREAD: u32 = 1 << 29;
const SPREAD_OF_HALLS: u32 = 1 << 30;
/// Angle that no rotor which follows turns: 360 degrees; 2^-30 turn. It ends a swing that a sensor
/// with swapped channels excites.
const FARTHEST: u32 = 1 << 30;
/// Largest lag: 40 degrees. A rotor that stands has 45 degrees.
const LAG: u32 = (1 << 30) / 9 * 4;
/// Largest error of an angle that is only checked: 20 degrees, and 30 degrees with Hall sensors,
/// whose wrong wires make it wrong by 60 degrees or more.
const LARGEST_ERROR: u32 = (1 << 30) / 9 * 2;
const LARGEST_ERROR_OF_HALLS: u32 = (1 << 30) / 3;

/// The last control periods at 90 degrees, in which the resistance is measured: the rotor has come
/// to rest.
const RESTS: i32 = SETTLE / 2;
/// Largest and smallest resistance, as multiples of that of the settings: these may be wrong by
/// 40 %, and a warm winding has 40 % more than a cold one.
const LARGEST_RESISTANCE: f32 = 2.0;
const SMALLEST_RESISTANCE: f32 = 0.5;
/// Voltage that dead time and diodes take, as a fraction of the supply voltage.
const UNEXPLAINED: f32 = 0.02;

/// Control periods of motion by which the field is set back (0 with Hall sensors, whose jumps are
/// no motion), the part of a new motion that counts at once, and the largest setback, 60 degrees.
const DAMPING: i32 = 6;
const FILTER_BITS: u32 = 2;
const LARGEST_SETBACK: i32 = (1 << 30) / 3 * 2;

const fn ticks(seconds: f32) -> i32 {
    (seconds / CONTROL_PERIOD + 0.5) as i32
}

/// Bounds of an alignment.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Current, A.
    current: f32,
    /// Largest distance from the start, 2^-32 turn of the output shaft.
    travel: u64,
    /// Largest error of a sensor that is absolute, whose angle the alignment checks and does not
    /// correct.
    checked: Option<u32>,
    /// Largest change of a distance, 2^-32 turn.
    spread: u32,
    /// Control periods of motion by which the field is set back.
    damping: i32,
    /// Resistance, ohm.
    resistance: f32,
}

impl Bounds {
    /// Reads the bounds from the settings.
    pub fn new(settings: &Settings) -> Self {
        let travel = Turns::from_radians(settings.si(Setting::AlignmentTravel));
        let sensor = RotorSensor::of(settings);
        let (spread, damping, largest) = if sensor.is_some_and(RotorSensor::has_halls) {
            (SPREAD_OF_HALLS, 0, LARGEST_ERROR_OF_HALLS)
        } else {
            (SPREAD, DAMPING, LARGEST_ERROR)
        };
        Self {
            current: settings.si(Setting::AlignmentCurrent),
            travel: travel.distance(),
            checked: sensor
                .is_some_and(RotorSensor::is_checked)
                .then_some(largest),
            spread,
            damping,
            resistance: settings.si(Setting::Resistance),
        }
    }
}

/// Readings of a control period.
#[derive(Clone, Copy, Debug)]
pub struct Observed {
    /// Position of the output shaft.
    pub position: Turns,
    /// Distance from the field of the previous period to the sensor's angle, once it is known.
    pub ahead: Option<ElectricalAngle>,
    /// Voltage along the field, V; 0 if it is not known.
    pub voltage: f32,
    /// Current along the field, A.
    pub current: f32,
    /// Supply voltage, V.
    pub supply_voltage: f32,
    /// No brake holds the rotor. While one does, the alignment waits after the rise of the current.
    pub free: bool,
}

/// What to do in a control period.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Progress {
    /// Drive this current, A, along this field.
    Drive(f32, ElectricalAngle),
    /// The rotor is this angle ahead of where its sensor shows it; 0 if the angle was only checked.
    Done(ElectricalAngle),
    /// The rotor has moved too far or did not follow, its sensor shows a wrong angle, or the
    /// resistance is wrong.
    Failed,
}

/// An alignment under way.
#[derive(Clone, Debug)]
pub struct Alignment {
    bounds: Bounds,
    /// Control periods since the start.
    ticks: i32,
    start: Option<Turns>,
    /// Field of the previous period, and where the sensor showed the rotor then.
    field: Angle,
    sensed: Option<Angle>,
    /// Angle by which the rotor has turned since the start, 2^-30 turn.
    turned: i32,
    /// Filtered motion of the rotor in a control period, 2^-32 turn.
    motion: i32,
    /// In both directions: the first distance from the field to the rotor, and the mean of the
    /// others less the first, 2^-32 turn.
    distances: [(Option<Angle>, i32); 2],
    /// Sums of voltage, V, current, A, and supply voltage, V, while the rotor rests.
    sums: [f32; 3],
}

impl Alignment {
    /// Creates an alignment that has not begun.
    pub fn new(bounds: Bounds) -> Self {
        Self {
            bounds,
            ticks: 0,
            start: None,
            field: Angle::QUARTER_TURN,
            sensed: None,
            turned: 0,
            motion: 0,
            distances: [(None, 0); 2],
            sums: [0.0; 3],
        }
    }

    /// Runs one control period. It is defined for every input and ends after 1.15 s without a
    /// brake.
    pub fn tick(&mut self, now: &Observed) -> Progress {
        let start = *self.start.get_or_insert(now.position);
        if (now.position - start).distance() > self.bounds.travel {
            return Progress::Failed;
        }
        if !self.resistance_is_right(now) {
            return Progress::Failed;
        }
        if let Some(ElectricalAngle(ahead)) = now.ahead {
            self.follow(ahead);
            if self.turned.unsigned_abs() > FARTHEST || !self.measure(ahead) {
                return Progress::Failed;
            }
        }
        if self.ticks >= END {
            return self.result();
        }
        if now.free || self.ticks < RISE {
            self.ticks += 1;
        }
        self.field = self.next_field();
        let rise = if self.ticks < RISE { self.ticks } else { RISE };
        let current = self.bounds.current * (rise as f32 / RISE as f32);
        Progress::Drive(current, ElectricalAngle(self.field))
    }

    /// Returns whether the current has risen, so that a brake may be released.
    pub fn has_risen(&self) -> bool {
        self.ticks >= RISE
    }

    /// Measures the resistance. Returns whether it is right, as far as it is known. NaN is wrong.
    fn resistance_is_right(&mut self, now: &Observed) -> bool {
        const AT_END: i32 = RISE + SETTLE;
        if self.ticks > AT_END - RESTS && self.ticks <= AT_END {
            let readings = [now.voltage, now.current, now.supply_voltage];
            for (sum, reading) in self.sums.iter_mut().zip(readings) {
                *sum += reading;
            }
        }
        if self.ticks != AT_END {
            return true;
        }
        let [voltage, current, supply_voltage] = self.sums;
        let expected = self.bounds.resistance * current;
        let unexplained = UNEXPLAINED * supply_voltage;
        voltage <= LARGEST_RESISTANCE * expected + unexplained
            && voltage >= SMALLEST_RESISTANCE * expected - unexplained
    }

    /// Measures the motion of the rotor.
    fn follow(&mut self, ahead: Angle) {
        let sensed = self.field - ahead;
        let last = self.sensed.replace(sensed).unwrap_or(sensed);
        let moved = (sensed - last).to_bits() >> FILTER_BITS;
        self.turned = self.turned.saturating_add(moved);
        self.motion += moved - (self.motion >> FILTER_BITS);
    }

    /// Adds the distance from the field to the rotor to the mean of its direction. Returns whether
    /// the rotor follows.
    fn measure(&mut self, ahead: Angle) -> bool {
        let direction = match self.ticks {
            ticks if ticks > BACKWARD - MEASURED && ticks <= BACKWARD => 0,
            ticks if ticks > END - MEASURED && ticks <= END => 1,
            _ => return true,
        };
        let (first, mean) = &mut self.distances[direction];
        let apart = (ahead - *first.get_or_insert(ahead)).to_bits();
        *mean += apart / MEASURED;
        apart.unsigned_abs() <= self.bounds.spread
    }

    fn result(&self) -> Progress {
        let [
            (Some(forward), more_forward),
            (Some(backward), more_backward),
        ] = self.distances
        else {
            return Progress::Failed;
        };
        let backward = backward + Angle::from_bits(more_backward);
        let forward = forward + Angle::from_bits(more_forward);
        let lag = Angle::from_bits((forward - backward).to_bits() / 2);
        let error = backward + lag;
        let largest = self.bounds.checked.unwrap_or(u32::MAX);
        let wrong = error.to_bits().unsigned_abs() > largest;
        if wrong || lag.to_bits().unsigned_abs() > LAG {
            return Progress::Failed;
        }
        let correction = if self.bounds.checked.is_some() {
            Angle::ZERO
        } else {
            error
        };
        Progress::Done(ElectricalAngle(correction))
    }

    fn next_field(&self) -> Angle {
        let ticks = self.ticks;
        let undamped = match ticks {
            ..AT_ZERO => {
                let turned = if ticks < RISE + SETTLE {
                    0
                } else {
                    ticks - RISE - SETTLE
                };
                (1 << 30) - STEP * turned
            }
            AT_ZERO..FORWARD => 0,
            // 180 degrees are the smallest number.
            FORWARD..BACKWARD => STEP.wrapping_mul(ticks - FORWARD),
            _ => STEP.wrapping_mul(END - ticks),
        };
        let setback = const { Bound::new(LARGEST_SETBACK / DAMPING) }.limit(self.motion)
            * self.bounds.damping;
        Angle::from_bits(undamped.wrapping_sub(setback))
    }
}
