//! Simulated motor of the lockstep boards: bridge, winding, rotor, gear, encoder and current
//! sensor.
//!
//! Uses only basic `f32` operations, so that the results on the emulated core and on the host are
//! bit-identical. The emulator computes each of them in a function of its own, and the model runs
//! 20 times in a step. Therefore [`Motor::new`] and [`Motor::set_load`] compute what does not change
//! between two PWM periods.

use super::noise::Noise;
use crate::boards::Bridge;
use tautrack::link::{MotorModel, Shaft};

const TURN: f32 = core::f32::consts::TAU;
/// Bound of every quantity in the model, A and rad/s: far above any motor and far below overflow.
const BOUND: f32 = 1e6;

/// One motor and its sensors, integrated once per PWM period.
#[derive(Clone, Debug)]
pub struct Motor {
    model: MotorModel,
    period: f32,
    noise: Noise,
    supply: f32,   // V
    load: f32,     // N m, at the rotor
    current: f32,  // A
    velocity: f32, // rad/s, of the rotor
    position: i64, // 2^-32 turn, of the output shaft
    residue: f32,  // fraction of the position below one 2^-32 turn
    position_per_radian: f32,
    counts_per_turn: i64, // of the output shaft, 2^-16 count
    current_rise: f32,    // A/V in one period
    current_damping: f32, // 1 + resistance times `current_rise`
    velocity_rise: f32,   // rad/s per N m in one period
    grip_driven: f32,     // speed that friction stops in one period, rad/s
    grip_with_brake: f32, // the same with the spring-applied brake
}

impl Motor {
    /// Creates a motor at rest. Returns `None` unless every value of `model` is finite, the
    /// friction, brake and sensor values are at least 0, and the others are positive.
    pub fn new(model: MotorModel, pwm_hz: u32, seed: u64) -> Option<Self> {
        let positive = [
            model.resistance,
            model.inductance,
            model.torque_constant,
            model.rotor_inertia,
            model.gear_ratio,
        ];
        let not_negative = [
            model.friction_torque,
            model.brake_torque,
            model.current_noise,
            model.current_quantum,
        ];
        let good = positive
            .iter()
            .all(|value| value.is_finite() && *value > 0.0)
            && not_negative
                .iter()
                .all(|value| value.is_finite() && *value >= 0.0)
            && model.encoder_counts > 0;
        let period = 1.0 / pwm_hz as f32;
        let current_rise = period / model.inductance;
        let velocity_rise = period / model.rotor_inertia;
        let grip = |friction: f32| velocity_rise * friction / model.gear_ratio;
        good.then(|| Self {
            model,
            period,
            noise: Noise::new(seed),
            supply: 0.0,
            load: 0.0,
            current: 0.0,
            velocity: 0.0,
            position: 0,
            residue: 0.0,
            position_per_radian: 4_294_967_296.0 / (TURN * model.gear_ratio),
            counts_per_turn: (model.gear_ratio * model.encoder_counts as f32 * 65_536.0) as i64,
            current_rise,
            current_damping: 1.0 + current_rise * model.resistance,
            velocity_rise,
            grip_driven: grip(model.friction_torque),
            grip_with_brake: grip(model.friction_torque + model.brake_torque),
        })
    }

    /// Sets the supply voltage (V) and the torque at the output shaft (N m) for the next periods.
    pub fn set_load(&mut self, supply_voltage: f32, shaft_torque: f32) {
        self.supply = bounded(supply_voltage);
        self.load = bounded(shaft_torque) / self.model.gear_ratio;
    }

    /// Integrates one PWM period with the bridge as given.
    ///
    /// Solves current and rotor one after the other, each implicitly in its own damping term
    /// (resistance; Coulomb friction). This is stable while the period is short compared with
    /// `sqrt(L J) / k`.
    pub fn integrate(&mut self, bridge: Bridge) {
        let model = &self.model;
        let emf = model.torque_constant * self.velocity;
        self.current = match bridge {
            Bridge::Drive(duty) => self.current_after(duty * self.supply - emf),
            Bridge::Brake => self.current_after(-emf),
            Bridge::Off => self.current_through_diodes(emf),
        };

        let torque = model.torque_constant * self.current - self.load;
        let free = bounded(self.velocity + self.velocity_rise * torque);
        // Coulomb friction reduces the speed, but never reverses it: below `grip` the rotor stands
        // still.
        let grip = match bridge {
            Bridge::Drive(_) => self.grip_driven,
            Bridge::Brake | Bridge::Off => self.grip_with_brake,
        };
        self.velocity = if free > grip {
            free - grip
        } else if free < -grip {
            free + grip
        } else {
            0.0
        };

        let moved = self.velocity * self.period * self.position_per_radian + self.residue;
        // The core converts 32 bits in one instruction, and calls a function for 64.
        let whole = if moved.abs() < 2_147_483_648.0 {
            let whole = moved as i32;
            self.residue = moved - whole as f32;
            i64::from(whole)
        } else {
            let whole = moved as i64;
            self.residue = moved - whole as f32;
            whole
        };
        self.position = self.position.wrapping_add(whole);
    }

    /// Returns the current after one period with `voltage` on resistance and inductance alone
    /// (backward Euler).
    fn current_after(&self, voltage: f32) -> f32 {
        bounded((self.current + self.current_rise * voltage) / self.current_damping)
    }

    /// Returns the current after one period with all transistors open. The diodes put the whole
    /// supply voltage against the current until it is zero. If no current flows, they conduct only
    /// where the back-EMF exceeds the supply.
    fn current_through_diodes(&self, emf: f32) -> f32 {
        let forward = if self.current == 0.0 {
            emf < 0.0
        } else {
            self.current > 0.0
        };
        let clamp = if forward { -self.supply } else { self.supply };
        let current = self.current_after(clamp - emf);
        if (current > 0.0) == forward {
            current
        } else {
            0.0
        }
    }

    /// Reading of the current sensor, A: the true current with noise, rounded to the steps of the
    /// converter.
    pub fn sampled_current(&mut self) -> f32 {
        let noisy = self.current + self.model.current_noise * self.noise.sample();
        let quantum = self.model.current_quantum;
        if quantum == 0.0 {
            return noisy;
        }
        let steps = noisy / quantum;
        let half = if steps < 0.0 { -0.5 } else { 0.5 };
        (steps + half) as i32 as f32 * quantum
    }

    /// Counts of the rotor's encoder since power-up, rounded down like an edge counter; wraps.
    pub fn encoder(&self) -> i32 {
        ((i128::from(self.position) * i128::from(self.counts_per_turn)) >> 48) as i32
    }

    /// Motion of the output shaft.
    pub fn shaft(&self) -> Shaft {
        Shaft {
            position: self.position,
            velocity: self.velocity / self.model.gear_ratio,
        }
    }
}

/// Clamps `value` to the model's bound; returns 0 for NaN.
fn bounded(value: f32) -> f32 {
    if value.abs() <= BOUND {
        value
    } else if value.is_nan() {
        0.0
    } else {
        BOUND.copysign(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: MotorModel = MotorModel {
        resistance: 0.3,
        inductance: 2e-4,
        torque_constant: 0.05,
        rotor_inertia: 1e-4,
        gear_ratio: 50.0,
        friction_torque: 1.0,
        brake_torque: 0.0,
        encoder_counts: 4096,
        current_noise: 0.0,
        current_quantum: 0.0,
    };

    fn motor(model: MotorModel) -> Motor {
        Motor::new(model, 20_000, 1).unwrap()
    }

    #[test]
    fn settles_where_the_motor_equation_says() {
        let mut motor = motor(MODEL);
        for _ in 0..40_000 {
            motor.set_load(24.0, 10.0);
            motor.integrate(Bridge::Drive(0.5));
        }
        // 12 V = R i + k w with k i N = load + friction
        let current = 11.0 / 50.0 / 0.05;
        let velocity = (12.0 - 0.3 * current) / 0.05 / 50.0;
        assert!((motor.current - current).abs() < 0.01, "{}", motor.current);
        assert!(
            (motor.shaft().velocity - velocity).abs() < 0.01,
            "{}",
            motor.shaft().velocity
        );
    }

    #[test]
    fn friction_holds_a_load_below_it_and_yields_above() {
        let mut motor = motor(MODEL);
        for _ in 0..2_000 {
            motor.set_load(24.0, 0.99);
            motor.integrate(Bridge::Off);
        }
        assert_eq!(motor.shaft(), Shaft::default());
        motor.set_load(24.0, 1.01);
        motor.integrate(Bridge::Off);
        assert!(motor.shaft().velocity < 0.0);
    }

    #[test]
    fn position_is_the_integral_of_velocity() {
        let mut motor = motor(MODEL);
        let mut angle = 0.0_f64;
        for _ in 0..200_000 {
            motor.set_load(24.0, 0.0);
            motor.integrate(Bridge::Drive(0.3));
            angle += f64::from(motor.velocity) / 20_000.0;
        }
        let turns = angle / core::f64::consts::TAU;
        assert!((motor.encoder() as f64 - turns * 4096.0).abs() < 1.0 + turns * 4096.0 * 1e-6);
        assert!(
            (motor.shaft().position as f64 / 2f64.powi(32) * 50.0 - turns).abs() < 1e-6 * turns
        );
    }

    #[test]
    fn open_bridge_ends_the_current_and_never_reverses_it() {
        let mut motor = motor(MODEL);
        for _ in 0..100 {
            motor.set_load(24.0, 0.0);
            motor.integrate(Bridge::Drive(0.9));
        }
        assert!(motor.current > 1.0);
        for _ in 0..100 {
            motor.set_load(24.0, 0.0);
            motor.integrate(Bridge::Off);
            assert!(motor.current >= 0.0);
        }
        assert_eq!(motor.current, 0.0);
    }

    #[test]
    fn driven_faster_than_the_supply_an_open_bridge_brakes() {
        let mut motor = motor(MODEL);
        motor.velocity = 1_000.0; // 50 V of back-EMF on 24 V
        motor.set_load(24.0, 0.0);
        motor.integrate(Bridge::Off);
        assert!(motor.current < 0.0);
    }

    #[test]
    fn everything_stays_finite() {
        let values = [
            0.0,
            1.0,
            -1.0,
            f32::MAX,
            f32::MIN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::NAN,
        ];
        let mut motor = motor(MotorModel {
            inductance: 1e-9,
            rotor_inertia: 1e-9,
            ..MODEL
        });
        for duty in values {
            for voltage in values {
                for torque in values {
                    for bridge in [Bridge::Drive(duty), Bridge::Brake, Bridge::Off] {
                        motor.set_load(voltage, torque);
                        motor.integrate(bridge);
                        assert!(
                            motor.shaft().velocity.is_finite()
                                && motor.sampled_current().is_finite()
                        );
                        assert!(motor.residue.is_finite());
                    }
                }
            }
        }
    }

    #[test]
    fn refuses_a_motor_that_cannot_be() {
        assert!(
            Motor::new(
                MotorModel {
                    resistance: 0.0,
                    ..MODEL
                },
                20_000,
                1
            )
            .is_none()
        );
        assert!(
            Motor::new(
                MotorModel {
                    friction_torque: f32::NAN,
                    ..MODEL
                },
                20_000,
                1
            )
            .is_none()
        );
    }
}
