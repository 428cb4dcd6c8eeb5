//! Finds a wrong rotor angle at low speed, where the back-EMF shows nothing.
//!
//! A rotor whose angle is wrong by `a` gets the torque `k (i_q cos a + i_d sin a)`. If it does not
//! follow `i_q`, then either something holds it, or `cos a` is nearly 0. In the second case a
//! current in d makes nearly its full torque; in the first case it makes none. So the probe adds an
//! alternating current in d and looks whether it turns the rotor. The current in q stays, up to
//! what the current limit leaves: a shaft that carries a load keeps its torque.
//!
//! The turn shows in the flux linkage of the axis d, which is the integral of the voltage that
//! resistance, inductance and coupling leave. It is the magnets' flux that turns into this axis. A
//! rotor with the right angle has none there, however it moves. No encoder is needed, so the probe
//! also finds one that is frozen.
//!
//! Two leads that are swapped, and an encoder that counts backwards, turn the axes against the
//! rotor. Then the turn shows in d or not, depending on where the rotor stands. But it shows in q:
//! there the flux changes by the turn of the encoder times the magnets' flux, with the right sign
//! only if the axes turn with the rotor.
//!
//! After a lead of two control periods, the current alternates in three parts: `- +`, `- +`, `+ -`.
//! Each part turns the rotor and leaves no speed; the third turns it the other way. The first part
//! minus twice the second plus the third is measured. In this sum, a constant speed and a constant
//! acceleration cancel. So do errors of the resistance and of the inductance in d, because the
//! current is zero on average in each part, and the lead makes the first part begin where the third
//! ends. In q the bound grows with what the changes of the current leave of these errors.
//!
//! The result counts only if the shaft has not followed until the end. A shaft that speeds up has
//! a large voltage by coupling, whose errors do not cancel.

use super::back_emf::{BackEmf, Observed};
use super::current::VOLTAGE_FULL_SCALE;
use crate::constants::CONTROL_PERIOD;
use crate::math::limit;
use crate::units::Angle;

/// Largest current of the probe, and what it leaves for the torque, as fractions of the current
/// limit.
const PROBE: f32 = 0.75;
const LEFT: f32 = 0.65;
/// Voltage that builds up the current of the probe in a control period, V. A larger inductance
/// leaves less current, so that the current can follow.
const SWING: f32 = 2.0;
/// Control periods of the lead, of each part, and of all.
const LEAD: u8 = 2;
const PART: u8 = 6;
const END: u8 = LEAD + 3 * PART;
/// Control periods in which the current is positive, the first in the lowest bit: of the lead, and
/// of the three parts.
const POSITIVE: u32 = 0b01 | 0b111_000 << 2 | 0b111_000 << 8 | 0b000_111 << 14;

/// Control periods for which the shaft must not gain speed while the current rises.
const STUCK: u8 = 4;
/// Gain of speed that counts, as a fraction of the velocity limit.
const GAIN: f32 = 0.002;
/// Rise of the current that counts, and the lowest current at its end, as fractions of the current
/// limit.
const RISE: f32 = 0.006;
const PUSHING: f32 = 0.03;
/// Largest speed during the probe, as a fraction of the velocity limit. Above it, the
/// back-EMF shows a wrong angle.
const SLOW: f32 = 0.2;
/// Gain of speed until the end of the probe, as a fraction of that, above which the shaft follows
/// after all.
const FOLLOWS: f32 = 0.4;

/// Flux in d that counts, as a fraction of the magnets' flux.
const FLUX: f32 = 0.2;
/// Flux in d per electrical radian that the encoder shows, as a fraction of the magnets' flux, up
/// to which the angle counts as right: the sine of 24 degrees.
const RIGHT: f32 = 0.4;
/// Flux in q that nothing explains and that counts, as a fraction of the magnets' flux, and per
/// electrical radian that the encoder shows.
const ACROSS: f32 = 0.5;
const ACROSS_TURN: f32 = 0.5;
/// Steps of the encoder by which the measured turn may be wrong.
const HIDDEN: f32 = 4.0;
/// Parts of the flux by coupling, of that by the resistance, and of that by changes of the current
/// in q that may be missing or excessive. The mean current of a control period does not show in
/// which part of the probe a change ends.
const COUPLED: f32 = 0.3;
const RESISTIVE: f32 = 0.6;
const INDUCTIVE: f32 = 0.4;

/// The probe of one motor.
#[derive(Clone, Debug)]
pub struct AngleProbe {
    /// Current of the probe, A; 0 for a brushed motor, and with Hall sensors, between whose edges a
    /// shaft turns unseen.
    current: f32,
    resistance: f32,
    inductance: f32,
    inductance_q: f32,
    /// Sign with which the electrical angle follows the counts of the encoder.
    direction: f32,
    /// Flux of the magnets, V s.
    magnets: f32,
    /// What the constants above mean for this motor, A and rad/s.
    rise: f32,
    pushing: f32,
    left: f32,
    gain: f32,
    slow: f32,
    /// Turn by which the measured one may be wrong, electrical rad.
    hidden: f32,

    /// Current at the last gain of speed, A, the lowest speed since then, rad/s, and its control
    /// periods.
    pushed: f32,
    slowest: f32,
    stuck: u8,
    /// Control period of the probe under way.
    step: Option<u8>,
    /// Currents in d and q, A, and electrical angle of the previous control period.
    currents: [f32; 2],
    angle: Angle,
    sums: Sums,
}

/// Weighted sums of a probe.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Turn by the encoder, electrical rad, in the direction of the counts.
    turn: f32,
    /// Flux that turns into d, and flux in q that the turn does not explain, V s.
    flux: f32,
    across: f32,
    /// Flux in d and q by coupling, V s.
    coupled: [f32; 2],
    /// Flux in q by the resistance, and sum of the sizes of that by changes of the current, V s.
    resistive: f32,
    inductive: f32,
}

impl AngleProbe {
    /// Creates the probe of the motor with these parameters.
    pub fn new(motor: &BackEmf) -> Self {
        let probes = motor.electrical != 0.0 && !motor.coarse;
        Self {
            current: if probes {
                let follows = SWING * CONTROL_PERIOD / motor.inductance[0];
                limit(PROBE * motor.current_limit, follows)
            } else {
                0.0
            },
            resistance: motor.resistance,
            inductance: motor.inductance[0],
            inductance_q: motor.inductance[1],
            direction: motor.direction as f32,
            magnets: motor.constant / motor.electrical,
            rise: RISE * motor.current_limit,
            pushing: PUSHING * motor.current_limit,
            left: LEFT * motor.current_limit,
            gain: GAIN * motor.velocity_limit,
            slow: SLOW * motor.velocity_limit,
            hidden: HIDDEN * motor.step,
            pushed: 0.0,
            slowest: 0.0,
            stuck: 0,
            step: None,
            currents: [0.0; 2],
            angle: Angle::ZERO,
            sums: Sums::default(),
        }
    }

    /// Ends a probe without a result, and begins to watch anew.
    pub fn reset(&mut self) {
        (self.step, self.stuck) = (None, 0);
    }

    /// Returns the current in d for the next control period, A.
    #[inline]
    pub fn direct(&self) -> f32 {
        match self.step {
            Some(step) if POSITIVE >> step & 1 != 0 => self.current,
            Some(_) => -self.current,
            None => 0.0,
        }
    }

    /// Returns the bound of the current that makes the torque, A: `bound`, or what a probe under
    /// way leaves. It begins below that. So the torque of a wrong angle, which rises, does not end
    /// it.
    #[inline]
    pub fn bound(&self, bound: f32) -> f32 {
        if self.step.is_some() && self.left < bound {
            self.left
        } else {
            bound
        }
    }

    /// Evaluates one control period. A probe begins only while the motor is `calm`. Returns whether
    /// a probe that ends now has found a wrong angle. NaN counts as a right one.
    #[inline]
    pub fn tick(&mut self, now: &Observed, calm: bool) -> bool {
        let Some(voltage) = now.electrical.voltage else {
            self.reset();
            return false;
        };
        let before = core::mem::replace(&mut self.currents, [now.electrical.direct, now.current]);
        let angle = now.electrical.angle.map_or(self.angle, |angle| angle.0);
        let turn = (angle - self.angle).radians() * self.direction;
        self.angle = angle;
        let Some(step) = self.step else {
            if self.current != 0.0 && self.does_not_follow(now) && calm {
                self.step = Some(0);
                self.sums = Sums::default();
            }
            return false;
        };
        if now.demand[1] != self.direct() || !self.is_slow(now) {
            // A limit left less current, so that errors do not cancel. Or the coupling is large.
            self.reset();
            return false;
        }
        if step < LEAD {
            // The current reaches its demand in a control period; its mean does not.
            self.currents[0] = self.direct();
        } else {
            let weight = if (step - LEAD) / PART == 1 { -2.0 } else { 1.0 };
            self.add(weight, voltage, before, turn);
        }
        if step + 1 < END {
            self.step = Some(step + 1);
            return false;
        }
        self.reset();
        let follows = along(now).0 > self.slowest + FOLLOWS * self.slow;
        !follows && self.shows_wrong_angle()
    }

    /// Adds a control period to the sums. `before` are the currents of the one before.
    #[inline]
    fn add(&mut self, weight: f32, voltage: [f32; 2], before: [f32; 2], turn: f32) {
        let [direct, current] = self.currents;
        let coupled_d = turn * current * self.inductance_q;
        let coupled_q = turn * direct * self.inductance;
        let resistive = self.resistance * current;
        let inductive = (current - before[1]) * self.inductance_q;
        let emf_d = limit(voltage[0] - self.resistance * direct, VOLTAGE_FULL_SCALE);
        let emf_q = voltage[1] - resistive;
        let rising = (direct - before[0]) * self.inductance;
        let explained = coupled_q + inductive + turn * self.magnets;
        let sums = &mut self.sums;
        sums.turn += weight * turn;
        sums.flux += weight * (emf_d * CONTROL_PERIOD + coupled_d - rising);
        sums.across += weight * (emf_q * CONTROL_PERIOD - explained);
        sums.coupled[0] += weight * coupled_d;
        sums.coupled[1] += weight * coupled_q;
        sums.resistive += weight * resistive * CONTROL_PERIOD;
        sums.inductive += (weight * inductive).abs();
    }

    fn shows_wrong_angle(&self) -> bool {
        let sums = &self.sums;
        let turn = sums.turn.abs();
        let [coupled_d, coupled_q] = sums.coupled.map(f32::abs);
        let direct = self.magnets * (FLUX + RIGHT * turn) + COUPLED * coupled_d;
        let across = self.magnets * (ACROSS + ACROSS_TURN * turn + self.hidden)
            + COUPLED * coupled_q
            + RESISTIVE * sums.resistive.abs()
            + INDUCTIVE * sums.inductive;
        sums.flux.abs() > direct || sums.across.abs() > across
    }

    fn is_slow(&self, now: &Observed) -> bool {
        now.velocity.abs() < self.slow
    }

    /// Returns whether the current rises while the shaft gains no speed in its direction.
    fn does_not_follow(&mut self, now: &Observed) -> bool {
        let demand = now.demand[0];
        let (along, push) = along(now);
        let reversed = demand * self.pushed < 0.0;
        if self.stuck == 0 || reversed || along > self.slowest + self.gain {
            (self.pushed, self.slowest, self.stuck) = (demand, along, 1);
            return false;
        }
        if along < self.slowest {
            self.slowest = along;
        }
        self.stuck = self.stuck.saturating_add(1);
        self.stuck > STUCK
            && self.is_slow(now)
            && push > self.pushed.abs() + self.rise
            && push > self.pushing
            && push < self.left
    }
}

/// Returns the speed in the direction of the demanded current, rad/s, and the size of the current,
/// A.
fn along(now: &Observed) -> (f32, f32) {
    let demand = now.demand[0];
    if demand < 0.0 {
        (-now.velocity, -demand)
    } else {
        (now.velocity, demand)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::current::Electrical;
    use crate::motor::rotor::ElectricalAngle;
    use crate::settings::{Setting, Settings};

    /// Runs a probe of the default motor, with three phases and 5 A, on a voltage in d that depends
    /// on the time since its start, s, and on the current of the probe, A. Returns whether it finds
    /// a wrong angle, and the currents.
    fn probe(voltage: impl Fn(f32, f32) -> f32) -> (bool, [f32; END as usize]) {
        probe_of_shaft(|time, direct| [voltage(time, direct), 0.0], |_| 0.0, 0.0)
    }

    /// The same with a voltage in q, and with an electrical angle, rad, of a shaft with this speed
    /// at the end, rad/s.
    fn probe_of_shaft(
        voltages: impl Fn(f32, f32) -> [f32; 2],
        angle: impl Fn(f32) -> f32,
        at_end: f32,
    ) -> (bool, [f32; END as usize]) {
        let mut settings = Settings::default();
        settings
            .set(Setting::MotorKind.description().key, 1)
            .unwrap();
        let mut probe = AngleProbe::new(&BackEmf::new(&settings));
        let (mut currents, mut count) = ([0.0; END as usize], 0);
        for tick in 0..100_u8 {
            let direct = probe.direct();
            let time = count as f32 * CONTROL_PERIOD;
            let now = Observed {
                current: 0.0,
                demand: [0.1 * f32::from(tick), direct],
                velocity: if count + 1 == usize::from(END) {
                    at_end
                } else {
                    0.0
                },
                supply_voltage: 24.0,
                electrical: Electrical {
                    voltage: Some(voltages(time, direct)),
                    direct,
                    angle: Some(ElectricalAngle(Angle::from_radians(angle(time)))),
                    ..Electrical::default()
                },
            };
            let wrong = probe.tick(&now, true);
            if direct != 0.0 {
                currents[count] = direct;
                count += 1;
                if probe.direct() == 0.0 {
                    assert_eq!(count, usize::from(END));
                    return (wrong, currents);
                }
            }
        }
        panic!("no probe");
    }

    #[test]
    fn the_current_leaves_a_rotor_no_speed_and_its_voltages_cancel() {
        // A resistance of 0.6 ohm, which may be twice as large, and any constant voltage.
        for ohm in [0.0, 0.6, 1.2] {
            let (wrong, currents) = probe(|_, direct| ohm * direct + 3.0);
            assert!(!wrong, "{ohm} ohm");
            let cancels = |currents: &[f32]| currents.iter().sum::<f32>().abs() < 1e-5;
            assert!(cancels(&currents));
            let parts = &currents[usize::from(LEAD)..];
            assert!(parts.chunks(usize::from(PART)).all(cancels));
        }
        // A back-EMF that rises steadily: constant acceleration.
        assert!(!probe(|time, _| 500.0 * time).0);
    }

    #[test]
    fn a_flux_that_follows_the_probe_is_found_from_a_fifth_of_the_magnets_flux_on() {
        for (part, found) in [(0.09, false), (0.11, true), (-0.11, true)] {
            assert_eq!(probe(turned_by(part)).0, found, "{part}");
        }
    }

    /// Start and length of the middle part of the probe, which counts twice, s.
    const MIDDLE: f32 = (LEAD + PART) as f32 * CONTROL_PERIOD;
    const LENGTH: f32 = PART as f32 * CONTROL_PERIOD;
    /// Flux of the magnets: torque constant / (1.5 x pole pairs), V s.
    const MAGNETS: f32 = 0.04 / 10.5;

    /// Returns the voltage of a flux that turns into d by this part of the magnets' flux, in the
    /// middle part of the probe only.
    fn turned_by(part: f32) -> impl Fn(f32, f32) -> f32 {
        let volts = part * MAGNETS / LENGTH;
        move |time, direct| {
            let inside = time > MIDDLE - 1e-4 && time < MIDDLE + LENGTH - 1e-4;
            0.6 * direct + if inside { volts } else { 0.0 }
        }
    }

    #[test]
    fn a_flux_in_q_that_does_not_follow_the_encoder_is_found() {
        // The rotor turns in the middle part. The encoder shows it, forwards or backwards.
        for (rotor, encoder, found) in [
            (0.5, 0.5, false),
            (0.5, 0.4, false),
            (-0.5, -0.5, false),
            (0.5, -0.5, true),
            (-0.5, 0.5, true),
            (0.2, 0.0, false),
            (0.4, 0.0, true),
        ] {
            let volts = turned_by(rotor);
            // The settings explain what resistance and coupling add to the voltages.
            let inductance = Settings::default().si(Setting::Inductance);
            let voltages = |time: f32, direct: f32| {
                let resistive = 0.6 * direct;
                let coupled = if volts(time, 0.0) == 0.0 {
                    0.0
                } else {
                    encoder / LENGTH * inductance * direct
                };
                [resistive, volts(time, 0.0) + coupled]
            };
            let angle = |time: f32| {
                let turned = (time - MIDDLE + CONTROL_PERIOD) / LENGTH;
                encoder * turned.clamp(0.0, 1.0)
            };
            let wrong = probe_of_shaft(voltages, angle, 0.0).0;
            assert_eq!(wrong, found, "{rotor} rad, encoder {encoder} rad");
        }
    }

    #[test]
    fn a_shaft_that_gains_a_twelfth_of_its_speed_limit_meanwhile_is_not_accused() {
        // The default velocity limit is 6 rad/s.
        for (at_end, found) in [(0.45, true), (0.51, false), (-0.51, true)] {
            let volts = turned_by(0.4);
            let voltages = |time: f32, direct: f32| [volts(time, direct), 0.0];
            let (wrong, _) = probe_of_shaft(voltages, |_| 0.0, at_end);
            assert_eq!(wrong, found, "{at_end}");
        }
    }
}
