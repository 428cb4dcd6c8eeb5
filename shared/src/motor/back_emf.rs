//! Compares the voltage of the bridge with the voltage that current and speed explain. What is left
//! over shows that the rotor sensor, the phases or the rotor's angle are not what the settings say.
//!
//! A winding takes `V = R i + e` on average, with the back-EMF `e`. A healthy three-phase motor has
//! no back-EMF in d. The back-EMF of a rotor whose angle is wrong by `a` leaves `e sin a` in d, and
//! `e (cos a - 1)` in q. So electrical power goes in, and less mechanical power comes out. A sensor
//! that stands still or counts backwards leaves the whole back-EMF, or twice the back-EMF.

use super::current::{Electrical, VOLTAGE_FULL_SCALE};
use super::halls::SECTOR;
use super::ripple::{Ripple, Unexplained};
use super::rotor::RotorSensor;
use crate::constants::CONTROL_PERIOD;
use crate::math::limit;
use crate::settings::{Setting, Settings};
use crate::units::Angle;
use core::f32::consts::TAU;

/// Part of the difference to a new error that the filter covers in a control period. It averages
/// over the voltages of changing currents, which are zero on average.
const FILTER: f32 = 0.3;
/// Error that no healthy motor has, as a fraction of the back-EMF at the velocity limit. The
/// settings may be wrong by 10 % in flux.
const LARGE: f32 = 0.25;
/// The same while the encoder shows no motion. Then the flux explains nothing.
const LARGE_STANDING: f32 = 0.06;
/// Part of the velocity limit below which the encoder shows no motion.
const STANDING: f32 = 0.01;
/// Part of the resistive voltage that may be missing or excessive. The resistance in the settings
/// may be wrong by 40 %.
const RESISTIVE: f32 = 0.6;
/// Part of the demanded current, and of the current limit, by which the currents may differ from
/// their demands if the back-EMF is wrong. The current in an open lead differs by more.
const FOLLOWS: f32 = 0.25;
const LOOSE: f32 = 0.03;
/// Demanded current above which a lack of current counts, as a fraction of the current limit.
const DRIVING: f32 = 0.1;
/// Current in d that Hall sensors cause, whose angle is rough, as a fraction of the current limit.
const ROUGH_CURRENT: f32 = 0.1;
/// Voltages that are never explained, as a fraction of the supply voltage: dead time, diodes.
const UNEXPLAINED: f32 = 0.02;
/// Part of the velocity limit below which a current that changes its sign is allowed the error of
/// the dead time that changes with it.
const SLOW: f32 = 0.03;
/// Part of the speed limit above which the angle is observed.
const OBSERVED: f32 = 0.08;
/// Back-EMF in d that a healthy motor does not have: the sine of 17 degrees.
const SLIPPED: f32 = 0.3;
/// Part of the voltage of the coupled axes that may be missing or excessive.
const COUPLED: f32 = 0.15;
/// The same where the voltage need not exceed its bound all the time.
const COUPLED_FAST: f32 = 0.3;
/// Part of the voltage by a change of the current that may be missing or excessive.
const INDUCTIVE: f32 = 0.2;
/// The same in d, where the probe's current changes within a control period: the mean current does
/// not show when.
const INDUCTIVE_DIRECT: f32 = 0.4;
/// Part of the voltages that are never explained which counts as wrong if it alternates.
const ALTERNATING: f32 = 0.5;
/// Parts of the back-EMF by the encoder which may be missing or excessive as an alternating
/// voltage, and in all.
const ROUGH: f32 = 0.1;
const ROUGH_WHOLE: f32 = 0.4;
/// Back-EMF in d beyond that, and how much faster it counts: the angle is wrong by 40 degrees.
const FAR: f32 = 0.3;
const FAST: u32 = 5;
/// Control periods, more with the finding than without, after which the angle has slipped.
const SLIPPED_PERIODS: u32 = 200;

/// Readings of one control period.
#[derive(Clone, Copy, Debug)]
pub struct Observed {
    /// Measured current that makes the torque, A.
    pub current: f32,
    /// The demanded currents that make the torque, and in d, A.
    pub demand: [f32; 2],
    /// Velocity by the encoder, rad/s of the output shaft.
    pub velocity: f32,
    /// Supply voltage, V.
    pub supply_voltage: f32,
    /// Voltages of the bridge.
    pub electrical: Electrical,
}

/// What one control period shows.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Findings {
    /// The voltage drives less than half of the demanded current, or a current in d as large as
    /// that flows: a lead of the motor is open.
    pub open_phase: bool,
    /// The voltage does not fit to the speed of the encoder.
    pub disagrees: bool,
    /// The back-EMF does not belong to the rotor's angle.
    pub slipped: bool,
}

impl Findings {
    /// Returns what also counts while the field turns the rotor: then the voltage has no axes of
    /// the rotor.
    #[must_use]
    pub fn of_turning_field(self) -> Self {
        Self {
            open_phase: self.open_phase,
            ..Self::default()
        }
    }
}

/// Parameters of the motor, and the filtered error.
#[derive(Clone, Debug)]
pub struct BackEmf {
    /// Back-EMF, V s/rad of the output shaft.
    pub(super) constant: f32,
    pub(super) resistance: f32,
    /// Inductances in d and q, henry.
    pub(super) inductance: [f32; 2],
    /// Electrical rad per rad of the output shaft; 0 for a brushed motor.
    pub(super) electrical: f32,
    /// Sign with which the electrical angle follows the counts of the encoder.
    pub(super) direction: i32,
    /// The same as `electrical`, times the inductances of d and q.
    pub(super) coupling: [f32; 2],
    /// rad/s of the output shaft per electrical rad in a control period; 0 for a brushed motor.
    per_turn: f32,
    /// One step of the encoder, electrical rad, and its back-EMF in a control period, V.
    pub(super) step: f32,
    quantum: f32,
    /// Hall sensors show the rotor: at low speed, its angle is wrong by up to a sector.
    pub(super) coarse: bool,
    pub(super) velocity_limit: f32,
    pub(super) current_limit: f32,
    /// Filtered voltage in d that nothing explains, V, and filtered square of the whole voltage
    /// that nothing explains, V^2. The square remains if the voltage turns in the axes of a wrong
    /// angle.
    direct: f32,
    square: f32,
    /// Currents in d and q of the previous control period, A, and its electrical angle.
    currents: [f32; 2],
    angle: Option<Angle>,
    /// Filtered difference of the currents to their demands, A.
    missing: f32,
    slipped: u32,
}

impl BackEmf {
    /// Reads the motor's parameters from the settings.
    pub fn new(settings: &Settings) -> Self {
        let three_phase = settings.get(Setting::MotorKind) != 0;
        let gear = settings.si(Setting::GearRatio);
        let inductance = settings.si(Setting::Inductance);
        let inductance_q = settings.si_or(Setting::InductanceQ, Setting::Inductance);
        let electrical = if three_phase {
            gear * settings.get(Setting::PolePairs) as f32
        } else {
            0.0
        };
        let torque_constant = settings.si(Setting::TorqueConstant) * gear;
        // The amplitude of three phases makes 3/2 of a phase's power.
        let constant = torque_constant / if three_phase { 1.5 } else { 1.0 };
        let coarse = RotorSensor::of(settings).is_some_and(RotorSensor::has_halls);
        let step = if coarse { SECTOR as f32 } else { 1.0 };
        let step = step * TAU / (gear * settings.get(Setting::EncoderCounts) as f32);
        Self {
            constant,
            resistance: settings.si(Setting::Resistance),
            inductance: [inductance, inductance_q],
            electrical,
            direction: if settings.get(Setting::PhaseOrder) < 0 {
                -1
            } else {
                1
            },
            coupling: [electrical * inductance, electrical * inductance_q],
            per_turn: if three_phase {
                1.0 / (electrical * CONTROL_PERIOD)
            } else {
                0.0
            },
            step: electrical * step,
            quantum: constant * step / CONTROL_PERIOD,
            coarse,
            velocity_limit: settings.si(Setting::VelocityLimit),
            current_limit: settings.si(Setting::CurrentLimit),
            direct: 0.0,
            square: 0.0,
            currents: [0.0; 2],
            angle: None,
            missing: 0.0,
            slipped: 0,
        }
    }

    /// Takes over the limits of these settings.
    pub fn retune(&mut self, settings: &Settings) {
        self.velocity_limit = settings.si(Setting::VelocityLimit);
        self.current_limit = settings.si(Setting::CurrentLimit);
    }

    /// Forgets what depends on the rotor's angle: it is not known.
    pub fn forget_angle(&mut self) {
        self.angle = None;
    }

    /// Returns the speed in this control period, rad/s of the output shaft. It is that of the
    /// rotor's angle, which does not lag behind as the velocity does, but jumps with Hall sensors.
    #[inline]
    fn speed(&mut self, now: &Observed) -> f32 {
        let angle = now.electrical.angle.map(|angle| angle.0);
        let (Some(before), Some(angle)) = (core::mem::replace(&mut self.angle, angle), angle)
        else {
            return now.velocity;
        };
        if self.coarse {
            return now.velocity;
        }
        let expected = Angle::from_radians(now.velocity * self.electrical * CONTROL_PERIOD);
        // In the direction of the counts.
        let turned = Angle::from_bits((angle - before).to_bits().wrapping_mul(self.direction));
        now.velocity + (turned - expected).radians() * self.per_turn
    }

    /// Evaluates one control period, also by the alternating voltages if `ripple` watches them.
    /// Nothing is found while the voltage is not known.
    #[inline]
    pub fn check(&mut self, now: &Observed, ripple: Option<&mut Ripple>) -> Findings {
        let Some([voltage_d, voltage_q]) = now.electrical.voltage else {
            (self.direct, self.square, self.slipped) = (0.0, 0.0, 0);
            (self.currents, self.missing) = ([now.electrical.direct, now.current], 0.0);
            self.forget_angle();
            ripple.into_iter().for_each(Ripple::reset);
            return Findings::default();
        };
        let (current, direct, velocity) = (now.current, now.electrical.direct, now.velocity);
        let [coupling_d, coupling_q] = self.coupling;
        let speed = self.speed(now);
        let [rising_d, rising_q] = [0, 1].map(|axis| {
            let change = [direct, current][axis] - self.currents[axis];
            change * self.inductance[axis] * (1.0 / CONTROL_PERIOD)
        });
        self.currents = [direct, current];
        let coupled = speed * current * coupling_q;
        let emf = speed * self.constant;
        let raw = [
            voltage_d - self.resistance * direct - rising_d + coupled,
            voltage_q - self.resistance * current - rising_q - speed * direct * coupling_d - emf,
        ];
        // No bridge gives more; NaN counts as no error.
        let [d, q] = raw.map(|raw| limit(raw, VOLTAGE_FULL_SCALE));
        self.direct += (d - self.direct) * FILTER;
        let unexplained = UNEXPLAINED * limit(now.supply_voltage, VOLTAGE_FULL_SCALE);
        let stands = velocity.abs() < STANDING * self.velocity_limit;
        let part = if stands { LARGE_STANDING } else { LARGE };
        let full_emf = self.constant * self.velocity_limit;
        let fixed = part * full_emf + unexplained;
        let most = 3.0 * (LARGE * full_emf + unexplained);
        let largest = most * most;
        // So one disturbed sample is forgotten before it is a finding.
        let square = d * d + q * q;
        let square = if square < largest { square } else { largest };
        self.square += (square - self.square) * FILTER;
        let direct_error = self.direct.abs();
        let resistance = RESISTIVE * self.resistance;
        let resistive = resistance * (current.abs() + direct.abs());
        let bound = fixed + resistive;
        let [demand, demand_d] = now.demand;
        let missing = (current - demand).abs() + (direct - demand_d).abs();
        self.missing += (missing - self.missing) * FILTER;
        let drives = demand.abs() > DRIVING * self.current_limit;
        // Without a demand that drives the motor, the watch of the leads finds nothing.
        let follows = !drives || self.missing < FOLLOWS * demand.abs() + LOOSE * self.current_limit;
        let swings = ripple.is_some_and(|ripple| {
            let explained = COUPLED_FAST * coupled.abs()
                + INDUCTIVE * rising_q.abs()
                + INDUCTIVE_DIRECT * rising_d.abs()
                + self.quantum;
            ripple.update(&Unexplained {
                voltage: [d, q],
                emf,
                current,
                resistance,
                alternating: explained
                    + ALTERNATING * unexplained
                    + ROUGH * emf.abs()
                    + resistance * direct.abs(),
                crossing: if velocity.abs() < SLOW * self.velocity_limit {
                    unexplained
                } else {
                    0.0
                },
                whole: explained + unexplained + ROUGH_WHOLE * emf.abs() + resistive,
                follows,
            })
        });
        let large = self.square > bound * bound;
        let half = 0.5 * demand.abs();
        let lacks = (current - demand).abs() > half;
        let rough = if self.coarse {
            ROUGH_CURRENT * self.current_limit
        } else {
            0.0
        };
        let oscillates = now.electrical.direct_size - demand_d.abs() > half + rough;
        let open = drives && (lacks && large || oscillates);

        let emf = velocity * self.constant;
        let threshold = SLIPPED * emf.abs() + COUPLED * coupled.abs() + 0.25 * unexplained;
        let fast = velocity.abs() > OBSERVED * self.velocity_limit;
        if self.electrical != 0.0 && fast && direct_error > threshold {
            let far = direct_error > threshold + FAR * emf.abs() + resistance * direct.abs();
            self.slipped = self.slipped.saturating_add(if far { FAST } else { 1 });
        } else {
            self.slipped = self.slipped.saturating_sub(1);
        }
        Findings {
            open_phase: open,
            disagrees: large && !open,
            slipped: self.slipped >= SLIPPED_PERIODS || swings,
        }
    }
}
