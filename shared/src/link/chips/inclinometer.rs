//! Model of the inclinometer LIS2DUXS12 (ST DS13884): identity, rate, range, reset and outputs.

use super::{Sampler, outputs};
use crate::link::{BodyMeasurands, ChipFault};
use crate::motor::model::noise::Noise;

/// Number of registers of the main page.
const COUNT: usize = 0x40;
const WHO_AM_I: usize = 0x0f;
const CTRL1: usize = 0x10;
const CTRL5: usize = 0x14;
const STATUS: usize = 0x25;
const OUT: usize = 0x28;
const OUT_END: usize = OUT + 6;

/// Identity of the chip, and of the one that replaces it as a fault (an LIS2DW12).
const IDENTITY: u8 = 0x47;
const OTHER_IDENTITY: u8 = 0x44;
/// Bit of CTRL1 that resets the registers.
const SW_RESET: u8 = 0x20;
/// Bit of STATUS: the chip has measured.
const READY: u8 = 0x01;

/// Registers after a reset: identity, and address increment in CTRL1.
const RESET: [u8; COUNT] = {
    let mut registers = [0; COUNT];
    registers[WHO_AM_I] = IDENTITY;
    registers[CTRL1] = 0x10;
    registers
};

/// The chip.
pub(super) struct Inclinometer {
    registers: [u8; COUNT],
    sampler: Sampler,
}

impl Inclinometer {
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
        // From 6.25 Hz on; the modes of the lowest rates are not modelled.
        let mut period = match self.registers[CTRL5] >> 4 {
            code @ 4..=11 => 160_000 >> (code - 4),
            _ => return,
        };
        if fault == Some(ChipFault::HalfRate) {
            period *= 2;
        }
        if !self.sampler.step(period) {
            return;
        }
        self.registers[STATUS] |= READY;
        if fault == Some(ChipFault::Frozen) {
            return;
        }
        // 0.061 mg a digit at 2 g.
        let digit = 9.806_65 * 0.061e-3 * (1_u32 << (self.registers[CTRL5] & 3)) as f32;
        let registers = &mut self.registers[OUT..OUT_END];
        outputs::write(registers, &acts.tilt_force, 1.0 / digit, fault, noise);
    }

    /// Reads registers from `register` on. Bytes behind the last register are 0.
    pub fn read(&mut self, register: u8, bytes: &mut [u8]) {
        let first = usize::from(register);
        bytes.fill(0);
        for (byte, register) in bytes.iter_mut().zip(self.registers.iter().skip(first)) {
            *byte = *register;
        }
        // A reading is no longer new when its last byte was read.
        if first < OUT_END && first + bytes.len() >= OUT_END {
            self.registers[STATUS] &= !READY;
        }
    }

    /// Writes registers from `register` on. Identity, status and outputs cannot be written.
    pub fn write(&mut self, register: u8, bytes: &[u8]) {
        for (place, byte) in (usize::from(register)..).zip(bytes) {
            if place < COUNT && place != WHO_AM_I && !(STATUS..OUT_END).contains(&place) {
                self.registers[place] = *byte;
            }
        }
        if self.registers[CTRL1] & SW_RESET != 0 {
            *self = Self::RESET;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps in which the chip has a new reading within a second, and its digits at the end.
    fn second(ctrl5: u8, fault: Option<ChipFault>) -> (u32, [i16; 3]) {
        let mut chip = Inclinometer::RESET;
        chip.write(CTRL5 as u8, &[ctrl5]);
        let acts = BodyMeasurands {
            tilt_force: [9.806_65, -1e6, f32::NAN],
            ..BodyMeasurands::default()
        };
        let (mut found, mut bytes) = (0, [0; 9]);
        for _ in 0..1_000 {
            chip.step(&acts, fault, &mut Noise::new(1));
            chip.read(STATUS as u8, &mut bytes);
            found += u32::from(bytes[0]);
            let mut status = [0];
            chip.read(STATUS as u8, &mut status);
            assert_eq!(status, [0], "a reading is new once");
        }
        let digits = [3, 5, 7].map(|byte| i16::from_le_bytes([bytes[byte], bytes[byte + 1]]));
        (found, digits)
    }

    #[test]
    fn it_measures_as_often_and_as_finely_as_the_data_sheet_says() {
        for (code, rate) in [(11, 800), (9, 200), (8, 100), (7, 50), (6, 25)] {
            // 1 g is 4098 digits of 0.244 mg, and 16393 of 0.061 mg.
            let eight_g = [4_098, i16::MIN, 0];
            assert_eq!(second(code << 4 | 2, None), (rate, eight_g));
            assert_eq!(second(code << 4, None), (rate, [16_393, i16::MIN, 0]));
            let half = second(code << 4 | 2, Some(ChipFault::HalfRate));
            assert!(half.0.abs_diff(rate / 2) <= 1, "{half:?}");
        }
        assert_eq!(second(2, None), (0, [0; 3]), "power-down");
        assert_eq!(second(0x82, Some(ChipFault::Frozen)), (100, [0; 3]));
    }

    #[test]
    fn a_reset_clears_the_configuration_and_the_identity_cannot_be_written() {
        let mut chip = Inclinometer::RESET;
        for (register, value) in [(WHO_AM_I, 1), (CTRL5, 0x82), (CTRL1, SW_RESET)] {
            chip.write(register as u8, &[value]);
        }
        let mut registers = [0; 6];
        chip.read(WHO_AM_I as u8, &mut registers);
        assert_eq!(registers, [IDENTITY, 0x10, 0, 0, 0, 0]);
    }
}
