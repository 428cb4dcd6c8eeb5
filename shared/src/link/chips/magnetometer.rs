//! Model of the magnetometer LIS2MDL (ST DS12144): rate, mode, reset and outputs.

use super::{Sampler, outputs};
use crate::link::{BodyMeasurands, ChipFault};
use crate::motor::model::noise::Noise;

/// First register of the model, and the number of its registers.
const FIRST: usize = 0x40;
const COUNT: usize = 0x30;
const WHO_AM_I: usize = 0x4f - FIRST;
const CFG_REG_A: usize = 0x60 - FIRST;
const STATUS: usize = 0x67 - FIRST;
const OUT: usize = 0x68 - FIRST;
const OUT_END: usize = OUT + 6;

/// Identity of the chip, and of the one that replaces it as a fault.
const IDENTITY: u8 = 0x40;
const OTHER_IDENTITY: u8 = 0x3d;
/// Bit of `CFG_REG_A` that resets the registers.
const SOFT_RST: u8 = 0x20;
/// Bits of STATUS: all axes have measured.
const READY: u8 = 0x0f;
/// Digits per uT: 1.5 mG a digit.
const DIGITS_PER_UNIT: f32 = 1.0 / 0.15;
/// Periods by the rate's code, us.
const PERIODS_US: [u32; 4] = [100_000, 50_000, 20_000, 10_000];

/// Registers after a reset: identity, and idle.
const RESET: [u8; COUNT] = {
    let mut registers = [0; COUNT];
    registers[WHO_AM_I] = IDENTITY;
    registers[CFG_REG_A] = 0x03;
    registers
};

/// The chip.
pub(super) struct Magnetometer {
    registers: [u8; COUNT],
    sampler: Sampler,
}

impl Magnetometer {
    pub const RESET: Self = Self {
        registers: RESET,
        sampler: Sampler::NEW,
    };

    /// Measures, if a measurement is due in this step.
    pub fn step(&mut self, acts: &BodyMeasurands, fault: Option<ChipFault>, noise: &mut Noise) {
        self.registers[WHO_AM_I] = if fault == Some(ChipFault::WrongIdentity) {
            OTHER_IDENTITY
        } else {
            IDENTITY
        };
        let configuration = self.registers[CFG_REG_A];
        let continuous = matches!(configuration & 0b11, 0);
        let mut period = PERIODS_US[usize::from(configuration >> 2 & 3)];
        if fault == Some(ChipFault::HalfRate) {
            period *= 2;
        }
        if !continuous || !self.sampler.step(period) {
            return;
        }
        self.registers[STATUS] = READY;
        if fault == Some(ChipFault::Frozen) {
            return;
        }
        let registers = &mut self.registers[OUT..OUT_END];
        outputs::write(
            registers,
            &acts.magnetic_field,
            DIGITS_PER_UNIT,
            fault,
            noise,
        );
    }

    /// Reads registers from `register` on. Registers that the model does not have are 0.
    pub fn read(&mut self, register: u8, bytes: &mut [u8]) {
        bytes.fill(0);
        let Some(first) = usize::from(register).checked_sub(FIRST) else {
            return;
        };
        for (byte, register) in bytes.iter_mut().zip(self.registers.iter().skip(first)) {
            *byte = *register;
        }
        // A reading is no longer new when its last byte was read.
        if first < OUT_END && first + bytes.len() >= OUT_END {
            self.registers[STATUS] = 0;
        }
    }

    /// Writes registers from `register` on. Identity, status and outputs cannot be written.
    pub fn write(&mut self, register: u8, bytes: &[u8]) {
        for (place, byte) in (usize::from(register)..).zip(bytes) {
            let place = place.wrapping_sub(FIRST);
            if place < STATUS && place != WHO_AM_I {
                self.registers[place] = *byte;
            }
        }
        if self.registers[CFG_REG_A] & SOFT_RST != 0 {
            *self = Self::RESET;
        }
    }
}
