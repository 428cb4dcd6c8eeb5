//! Model of the inertial unit LSM6DSV16X (ST DS13510): the registers of its main page that set rate
//! and range, and its outputs.

use super::{Sampler, outputs};
use crate::link::{BodyMeasurands, ChipFault};
use crate::motor::model::noise::Noise;
use core::f32::consts::PI;

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
    pub fn step(&mut self, acts: &BodyMeasurands, fault: Option<ChipFault>, noise: &mut Noise) {
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
                let registers = &mut self.registers[OUT_ACCELEROMETER..OUT_END];
                let scale = self.digits_per_unit[0];
                outputs::write(registers, &acts.specific_force, scale, fault, noise);
            }
        }
        if gyroscope > 0 && self.gyroscope.step(gyroscope * slower) {
            self.registers[STATUS] |= READY_GYROSCOPE;
            if !keep {
                let registers = &mut self.registers[OUT_GYROSCOPE..OUT_ACCELEROMETER];
                let scale = self.digits_per_unit[1];
                outputs::write(registers, &acts.angular_rate, scale, fault, noise);
            }
        }
        self.registers[WHO_AM_I] = if fault == Some(ChipFault::WrongIdentity) {
            OTHER_IDENTITY
        } else {
            IDENTITY
        };
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A chip whose registers were written so, at rest on level ground.
    fn chip(writes: &[(usize, u8)]) -> (InertialUnit, BodyMeasurands) {
        let mut chip = InertialUnit::RESET;
        for (register, value) in writes {
            chip.write(*register as u8, &[*value]);
        }
        let acts = BodyMeasurands {
            specific_force: [0.0, -1e6, 9.806_65],
            angular_rate: [f32::NAN, PI, -PI / 180.0],
            ..BodyMeasurands::default()
        };
        (chip, acts)
    }

    /// Digits of gyroscope and accelerometer.
    fn outputs(chip: &mut InertialUnit) -> [i16; 6] {
        let mut outputs = [0; 12];
        chip.read(OUT_GYROSCOPE as u8, &mut outputs);
        let mut pairs = outputs.chunks(2);
        core::array::from_fn(|_| {
            let pair = pairs.next().expect("six outputs");
            i16::from_le_bytes([pair[0], pair[1]])
        })
    }

    #[test]
    fn it_measures_as_often_as_the_data_sheet_says_and_half_as_often_with_the_fault() {
        // Mode with accurate rates: code and table of rates, and the rate in Hz.
        for (code, table, rate) in [(9, 1, 1_000), (8, 1, 500), (9, 2, 800), (6, 2, 100)] {
            for (fault, share) in [(None, 1), (Some(ChipFault::HalfRate), 2)] {
                let registers = [(HAODR_CFG, table), (CTRL1, 0x10 | code)];
                let (mut chip, acts) = chip(&registers);
                let mut found = 0;
                for _ in 0..1_000 {
                    chip.step(&acts, fault, &mut Noise::new(0));
                    let mut status = [0];
                    chip.read(STATUS as u8, &mut status);
                    found += u32::from(status[0] == READY_ACCELEROMETER);
                    chip.read(OUT_ACCELEROMETER as u8, &mut [0; 6]);
                    chip.read(STATUS as u8, &mut status);
                    assert_eq!(status, [0], "a reading is new once");
                }
                assert_eq!(found, rate / share, "code {code} of table {table}");
            }
        }
    }

    #[test]
    fn digits_are_those_of_the_range_and_saturate() {
        let registers = [(CTRL8, 2), (CTRL6, 3), (CTRL1, 9), (CTRL2, 9)];
        let (mut chip, acts) = chip(&registers);
        for _ in 0..3 {
            chip.step(&acts, None, &mut Noise::new(0));
        }
        let values = outputs(&mut chip);
        // 180 degrees/s are 5143 digits of 35 mdegree/s, and 1 g is 4098 digits of 0.244 mg.
        assert_eq!(values, [0, 5_143, -29, 0, i16::MIN, 4_098]);
    }

    #[test]
    fn with_noise_each_output_is_off_by_up_to_a_quarter_of_the_range() {
        let (mut chip, _) = chip(&[(CTRL1, 9), (CTRL2, 9)]);
        let acts = BodyMeasurands::default();
        let (mut noise, mut squares, mut most) = (Noise::new(1), 0.0_f64, 0);
        for _ in 0..10_000 {
            chip.step(&acts, Some(ChipFault::Noise), &mut noise);
            for value in outputs(&mut chip) {
                squares += f64::from(value).powi(2);
                most = value.abs().max(most);
            }
        }
        assert!((8_100..=8_192).contains(&most), "{most}");
        // A uniform number has a third of the square of its bound, in the mean.
        let deviation = (squares / 60_000.0).sqrt();
        assert!(
            (deviation - 8_192.0 / 3.0_f64.sqrt()).abs() < 50.0,
            "{deviation}"
        );
    }

    #[test]
    fn a_reset_clears_the_configuration_and_the_identity_cannot_be_written() {
        let (mut chip, acts) = chip(&[(WHO_AM_I, 1), (CTRL1, 9), (CTRL3, SW_RESET)]);
        chip.step(&acts, None, &mut Noise::new(0));
        let mut registers = [0; 4];
        chip.read(WHO_AM_I as u8, &mut registers);
        assert_eq!(registers, [IDENTITY, 0, 0, 0x44]);
    }
}
