//! Model of the inertial unit LSM6DSV16X (ST DS13510): the registers of its main page that set rate
//! and range, and its outputs.

use super::{Sampler, digits};
use core::f32::consts::PI;
use tautrack::link::{BodyMeasurands, ChipFault};

/// Number of registers of the main page.
const COUNT: usize = 0x80;
const WHO_AM_I: usize = 0x0f;
const CTRL1: usize = 0x10;
const CTRL2: usize = 0x11;
const CTRL3: usize = 0x12;
const CTRL6: usize = 0x15;
const CTRL8: usize = 0x17;
const STATUS: usize = 0x1e;
const OUT_GYROSCOPE: usize = 0x22;
const OUT_ACCELEROMETER: usize = 0x28;
const OUT_END: usize = 0x2e;
const HAODR_CFG: usize = 0x62;

/// Identity of the chip, and of the one that replaces it as a fault (an LSM6DSO).
const IDENTITY: u8 = 0x70;
const OTHER_IDENTITY: u8 = 0x6c;
/// Bit of CTRL3 that resets the registers.
const SW_RESET: u8 = 0x01;
/// Bits of STATUS: accelerometer and gyroscope have measured.
const READY_ACCELEROMETER: u8 = 0x01;
const READY_GYROSCOPE: u8 = 0x02;

/// Registers after a reset: identity, and block update and address increment in CTRL3.
const RESET: [u8; COUNT] = {
    let mut registers = [0; COUNT];
    registers[WHO_AM_I] = IDENTITY;
    registers[CTRL3] = 0x44;
    registers
};

/// The chip.
pub(super) struct InertialUnit {
    registers: [u8; COUNT],
    accelerometer: Sampler,
    gyroscope: Sampler,
    /// Periods, us, and digits per m/s^2 and per rad/s that the registers set; a period of 0 is
    /// off.
    periods_us: [u32; 2],
    digits_per_unit: [f32; 2],
}

impl InertialUnit {
    pub const RESET: Self = Self {
        registers: RESET,
        accelerometer: Sampler::NEW,
        gyroscope: Sampler::NEW,
        periods_us: [0; 2],
        digits_per_unit: [0.0; 2],
    };

    /// Measures, if a measurement is due in this step.
    pub fn step(&mut self, acts: &BodyMeasurands, fault: Option<ChipFault>) {
        let slower = if fault == Some(ChipFault::HalfRate) {
            2
        } else {
            1
        };
        let [accelerometer, gyroscope] = self.periods_us;
        let keep = fault == Some(ChipFault::Frozen);
        if accelerometer > 0 && self.accelerometer.step(accelerometer * slower) {
            self.registers[STATUS] |= READY_ACCELEROMETER;
            if !keep {
                self.output(
                    OUT_ACCELEROMETER,
                    &acts.specific_force,
                    self.digits_per_unit[0],
                );
            }
        }
        if gyroscope > 0 && self.gyroscope.step(gyroscope * slower) {
            self.registers[STATUS] |= READY_GYROSCOPE;
            if !keep {
                self.output(OUT_GYROSCOPE, &acts.angular_rate, self.digits_per_unit[1]);
            }
        }
        self.registers[WHO_AM_I] = if fault == Some(ChipFault::WrongIdentity) {
            OTHER_IDENTITY
        } else {
            IDENTITY
        };
    }

    fn output(&mut self, register: usize, values: &[f32; 3], digits_per_unit: f32) {
        for (axis, value) in values.iter().enumerate() {
            let place = register + 2 * axis;
            self.registers[place..place + 2].copy_from_slice(&digits(*value, digits_per_unit));
        }
    }

    /// Reads registers from `register` on. Bytes behind the last register are 0.
    pub fn read(&mut self, register: u8, bytes: &mut [u8]) {
        let first = usize::from(register);
        bytes.fill(0);
        for (byte, register) in bytes.iter_mut().zip(self.registers.iter().skip(first)) {
            *byte = *register;
        }
        // A reading is no longer new when its last byte was read.
        let last = first + bytes.len();
        if first < OUT_ACCELEROMETER && last >= OUT_ACCELEROMETER {
            self.registers[STATUS] &= !READY_GYROSCOPE;
        }
        if first < OUT_END && last >= OUT_END {
            self.registers[STATUS] &= !READY_ACCELEROMETER;
        }
    }

    /// Writes registers from `register` on. Identity, status and outputs cannot be written.
    pub fn write(&mut self, register: u8, bytes: &[u8]) {
        for (place, byte) in (usize::from(register)..).zip(bytes) {
            if place < COUNT && place != WHO_AM_I && !(STATUS..OUT_END).contains(&place) {
                self.registers[place] = *byte;
            }
        }
        if self.registers[CTRL3] & SW_RESET != 0 {
            *self = Self::RESET;
        }
        self.periods_us = [self.period(CTRL1), self.period(CTRL2)];
        // 0.061 mg a digit at 2 g, and 4.375 mdegree/s a digit at 125 degrees/s.
        let force = 9.806_65 * 0.061e-3 * (1_u32 << (self.registers[CTRL8] & 3)) as f32;
        let range = match self.registers[CTRL6] & 0x0f {
            0x0c => 5,
            code => code & 0x07,
        };
        let rate = 4.375e-3 * PI / 180.0 * (1_u32 << range) as f32;
        self.digits_per_unit = [1.0 / force, 1.0 / rate];
    }

    /// Period that the register of one sensor sets, us; 0 if the sensor is off. The lowest rates
    /// are not modelled.
    fn period(&self, register: usize) -> u32 {
        let code = u32::from(self.registers[register] & 0x0f);
        let high_accuracy = self.registers[register] >> 4 & 7 == 1;
        let slowest = match (high_accuracy, self.registers[HAODR_CFG] & 3) {
            (true, 1) => 64_000,
            (true, 2) => 80_000,
            _ => 66_667,
        };
        match code {
            3..=12 => slowest >> (code - 3),
            _ => 0,
        }
    }
}
