//! Models of motors and of their sensors, for boards that have no hardware.
//!
//! [`Motor`] is what the PWM interrupt meets: bridge, winding, rotor, gear, rotor sensor and
//! current converter. `winding` has the electrical part, `noise` the noise of the converter.
//!
//! The models use only basic `f32` operations and the sines of this crate, so that the results on
//! the emulated core and on the host are bit-identical.

pub mod noise;
mod parameters;
mod winding;

pub use parameters::{MotorModel, Shaft, ThreePhaseModel, WindingModel};

use crate::math::trig::sin_cos;
use crate::motor::bridge::{PowerStage, Ratings, Readings};
use crate::motor::halls;
use crate::units::Angle;
use noise::Noise;
use winding::{Supply, Winding};

/// The simulated power stage: 20 kHz, compare values as on a timer with 170 MHz that counts up and
/// down, a current range that suits every motor of the simulated robots, and the supply voltage
/// that the motor board bears.
pub const POWER_STAGE: Ratings = Ratings {
    pwm_hz: 20_000,
    period: 4_250,
    highest: 4_250,
    sampled: 4_250,
    full_scale: 160.0,
    highest_supply: 36.0,
};

const TURN: f32 = core::f32::consts::TAU;
/// Bound of every quantity in the model, A and rad/s: far above any motor and far below overflow.
const BOUND: f32 = 1e6;

/// One motor and its sensors, integrated once per PWM period.
///
/// The emulator computes each floating-point operation in a function of its own, and each
/// comparison in two. Therefore [`Motor::new`] and [`Motor::set_load`] compute what does not change
/// between two periods, and the periods compare the bits of the numbers (`magnitude`).
#[derive(Clone, Debug)]
pub struct Motor {
    model: MotorModel,
    codes_per_ampere: f32,
    noise: Noise,
    winding: Winding,
    supply: Supply,
    load: f32,     // N m, at the rotor
    velocity: f32, // rad/s, of the rotor
    position: i64, // 2^-32 turn, of the output shaft
    residue: f32,  // fraction of the position below one 2^-32 turn
    /// Position that the rotor sensor shows.
    sensed: i64,
    /// Turns of the rotor sensor at the last call of [`Motor::take_index`]; wraps.
    turns: i16,
    sensor_frozen: bool,
    brake_released: bool,
    open_lead: Option<usize>,
    moved_per_velocity: f32, // 2^-32 turn of the output shaft, in one period, per rad/s
    velocity_rise: f32,      // rad/s per N m, in one period
    grip_driven: f32,        // speed that friction stops in one period, rad/s
    grip_with_brake: f32,    // the same with the spring-applied brake
    counts_per_turn: i64,    // of the output shaft, 2^-16 count
    rotor_per_shaft: i64,    // turns, 2^-16
    /// Angle of the rotor at power-up.
    start: Angle,
}

impl Motor {
    /// Creates a motor at rest at a power stage. Returns `None` unless every value of `model` is
    /// finite, the friction, brake and sensor values are at least 0, and the others are positive.
    pub fn new(model: MotorModel, ratings: Ratings, seed: u64) -> Option<Self> {
        let positive = [model.rotor_inertia, model.gear_ratio];
        let not_negative = [
            model.friction_torque,
            model.brake_torque,
            model.current_noise,
            model.current_quantum,
            model.dead_time,
        ];
        let good = positive
            .iter()
            .all(|value| value.is_finite() && *value > 0.0)
            && not_negative
                .iter()
                .all(|value| value.is_finite() && *value >= 0.0)
            && model.encoder_counts > 0;
        if !good {
            return None;
        }
        let period = 1.0 / ratings.pwm_hz as f32;
        let velocity_rise = period / model.rotor_inertia;
        let grip = |friction: f32| velocity_rise * friction / model.gear_ratio;
        let mut noise = Noise::new(seed);
        let start = match model.winding {
            WindingModel::Brushed { .. } => Angle::ZERO,
            WindingModel::ThreePhase(_) => Angle::from_bits(noise.bits() as i32),
        };
        let mut winding = Winding::new(model.winding, period)?;
        winding.turn_to(start);
        Some(Self {
            codes_per_ampere: 32_768.0 / ratings.full_scale,
            noise,
            winding,
            supply: Supply::new(&ratings, model.dead_time),
            load: 0.0,
            velocity: 0.0,
            position: 0,
            residue: 0.0,
            sensed: 0,
            turns: 0,
            sensor_frozen: false,
            brake_released: false,
            open_lead: None,
            moved_per_velocity: period * 4_294_967_296.0 / (TURN * model.gear_ratio),
            velocity_rise,
            grip_driven: grip(model.friction_torque),
            grip_with_brake: grip(model.friction_torque + model.brake_torque),
            counts_per_turn: (model.gear_ratio * model.encoder_counts as f32 * 65_536.0) as i64,
            rotor_per_shaft: (model.gear_ratio * 65_536.0) as i64,
            start,
            model,
        })
    }

    /// Sets the supply voltage (V, at least 0) and the torque at the output shaft (N m) for the
    /// next periods.
    pub fn set_load(&mut self, supply_voltage: f32, shaft_torque: f32) {
        self.supply.set(bounded(supply_voltage).max(0.0));
        self.load = bounded(shaft_torque) / self.model.gear_ratio;
    }

    /// Makes the rotor sensor keep its last reading, or work again.
    pub fn freeze_sensor(&mut self, frozen: bool) {
        self.sensor_frozen = frozen;
    }

    /// Releases the spring-applied brake, or lets it engage. It is engaged at power-up.
    pub fn release_brake(&mut self, released: bool) {
        self.brake_released = released;
    }

    /// Opens the lead of half bridge a, b or c (0, 1 or 2), or closes all again.
    pub fn open_lead(&mut self, lead: Option<usize>) {
        self.open_lead = lead;
    }

    /// Integrates one PWM period with this command to the power stage.
    ///
    /// Solves currents and rotor one after the other, each implicitly in its own damping term
    /// (resistance; Coulomb friction). This is stable while the period is short compared with
    /// `sqrt(L J) / k`.
    pub fn integrate(&mut self, stage: PowerStage) {
        let rotor = self.rotor_angle(self.position);
        let driving = self.winding.integrate(stage, &self.supply, self.velocity);
        if let Some(lead) = self.open_lead {
            self.winding.open_lead(lead);
        }
        let torque = driving - self.cogging_torque(rotor);
        let free = bounded(self.velocity + self.velocity_rise * (torque - self.load));
        // Coulomb friction reduces the speed, but never reverses it: below `grip` the rotor stands
        // still.
        let grip = if self.brake_released {
            self.grip_driven
        } else {
            self.grip_with_brake
        };
        self.velocity = if magnitude(free) > magnitude(grip) {
            free - grip.copysign(free)
        } else {
            0.0
        };

        let moved = self.velocity * self.moved_per_velocity + self.residue;
        // The core converts 32 bits in one instruction, and calls a function for 64.
        let whole = if magnitude(moved) < magnitude(2_147_483_648.0) {
            let whole = moved as i32;
            self.residue = moved - whole as f32;
            i64::from(whole)
        } else {
            let whole = moved as i64;
            self.residue = moved - whole as f32;
            whole
        };
        self.position = self.position.wrapping_add(whole);
        self.winding.turn_to(self.rotor_angle(self.position));
        if !self.sensor_frozen {
            self.sensed = self.position;
        }
    }

    /// Angle of the rotor at this position of the output shaft; 0 where the rotor sensor reads 0.
    fn rotor_angle(&self, position: i64) -> Angle {
        // The bits 16 to 47 of the product are exact although it wraps at 64 bits.
        let moved = position.wrapping_mul(self.rotor_per_shaft) >> 16;
        self.start + Angle::from_bits(moved as i32)
    }

    fn cogging_torque(&self, rotor: Angle) -> f32 {
        match &self.model.winding {
            WindingModel::ThreePhase(winding) if magnitude(winding.cogging_torque) != 0 => {
                let angle = rotor
                    .to_bits()
                    .wrapping_mul(i32::from(winding.cogging_periods));
                winding.cogging_torque * sin_cos(Angle::from_bits(angle)).0
            }
            _ => 0.0,
        }
    }

    /// Readings of the sensors: codes of the phase currents, and the rotor's count within its turn.
    ///
    /// A three-phase motor has a sensor that is absolute within a turn of the rotor. At power-up
    /// the rotor stands somewhere in this turn.
    pub fn readings(&mut self) -> Readings {
        let rotor = self.rotor_angle(self.sensed);
        let currents = self.winding.phase_currents();
        let turn = u64::from(rotor.to_bits() as u32);
        Readings {
            currents: currents.map(|current| self.code(current)),
            rotor: ((turn * u64::from(self.model.encoder_counts)) >> 32) as u32,
            third: None,
            over_voltage: false,
        }
    }

    /// Levels of three Hall sensors ([`halls::code`]), each displaced by an angle. They freeze with
    /// the rotor sensor.
    pub fn halls(&self, displaced: [Angle; 3]) -> u32 {
        let rotor = self.rotor_angle(self.sensed);
        halls::code(self.winding.electrical(rotor), displaced)
    }

    /// Code of a current: with noise, in steps of the model's quantum, left-aligned.
    fn code(&mut self, current: f32) -> u16 {
        let noisy = current + self.model.current_noise * self.noise.sample();
        let quantum = self.model.current_quantum;
        let stepped = if magnitude(quantum) == 0 {
            noisy
        } else {
            rounded(noisy / quantum) as f32 * quantum
        };
        let code = rounded(stepped * self.codes_per_ampere);
        (code.clamp(-32_768, 32_767) + 32_768) as u16
    }

    /// Returns the count ([`Motor::encoder`]) at which the sensor has passed the zero of its turn,
    /// if it has since the last call, which is at most half a turn ago. The index of an encoder
    /// gives a pulse there.
    pub fn take_index(&mut self) -> Option<i32> {
        // The product wraps at 64 bits; the lowest 16 bits of the turns are exact.
        let moved = self.sensed.wrapping_mul(self.rotor_per_shaft) >> 16;
        let turned = moved.wrapping_add(i64::from(self.start.to_bits() as u32));
        let turns = (turned >> 32) as i16;
        if core::mem::replace(&mut self.turns, turns) == turns {
            return None;
        }
        // Counts since the zero, or up to it.
        let counts = u64::from(self.model.encoder_counts);
        let past = (u64::from(turned as u32) * counts) >> 32;
        let past = if past < counts / 2 {
            past as i32
        } else {
            past as i32 - counts as i32
        };
        Some(self.encoder().wrapping_sub(past))
    }

    /// Counts of the rotor's encoder since power-up, rounded down like an edge counter; wraps.
    pub fn encoder(&self) -> i32 {
        ((i128::from(self.sensed) * i128::from(self.counts_per_turn)) >> 48) as i32
    }

    /// Motion of the output shaft.
    pub fn shaft(&self) -> Shaft {
        Shaft {
            position: self.position,
            velocity: self.velocity / self.model.gear_ratio,
        }
    }
}

/// Converts `value` to the nearest integer; saturates, 0 for NaN.
fn rounded(value: f32) -> i32 {
    (value + 0.5_f32.copysign(value)) as i32
}

/// The bits of `|value|`. As integers they have the order of the magnitudes; NaN is above them all.
#[inline]
fn magnitude(value: f32) -> u32 {
    value.to_bits() & 0x7fff_ffff
}

/// Clamps `value` to the model's bound; returns 0 for NaN.
#[inline]
fn bounded(value: f32) -> f32 {
    if magnitude(value) <= magnitude(BOUND) {
        value
    } else if value.is_nan() {
        0.0
    } else {
        BOUND.copysign(value)
    }
}
