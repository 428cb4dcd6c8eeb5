//! Absolute angle sensor at the output shaft: what its registers mean. The chips are magnetic and
//! have an I2C bus (data sheets of ams: AS5600, AS5048A/B).
//!
//! Such a sensor is no rotor sensor. A transfer takes 0.4 ms at 200 kbit/s, and the filter of the
//! AS5600 another 2.2 ms. A rotor with 7 pole pairs turns by 5 electrical degrees in this time at
//! 46 rev/min.

use crate::settings::{Setting, Settings};
use crate::units::Angle;

/// Number of registers that are read in one transfer: the largest of all chips.
pub const LENGTH: usize = 5;

/// Kind of the chip.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// AS5600, 12 bits.
    As5600,
    /// AS5048B, 14 bits, with its address pins at ground.
    As5048b,
}

/// Condition of the sensor. The codes are those of the guard's sensor chips (object 0x2112), with
/// one more.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[repr(u8)]
pub enum Condition {
    /// There is no sensor in the settings, or it was not read yet.
    #[default]
    Absent = 0,
    /// The last transfer gave an angle.
    Running = 1,
    /// No chip acknowledges the address.
    NoAcknowledge = 2,
    /// A line of the bus is held low.
    BusStuck = 3,
    /// The chip finds no magnet, or its angle is not valid.
    NoMagnet = 7,
}

/// What a board knows of its sensor.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Reading {
    /// Condition of the sensor.
    pub condition: Condition,
    /// Number of transfers that gave no angle, up to its maximum.
    pub errors: u16,
    /// Number of the newest angle; it wraps. An angle with the same number is not a new one.
    pub number: u8,
    /// The newest angle.
    pub angle: Angle,
}

impl Kind {
    /// Returns the sensor of these settings.
    pub fn of(settings: &Settings) -> Option<Self> {
        match settings.get(Setting::ShaftSensor) {
            1 => Some(Self::As5600),
            2 => Some(Self::As5048b),
            _ => None,
        }
    }

    /// Returns the chip's address, and the first of the registers that [`Self::decode`] needs. The
    /// chip reads on with the next one.
    pub fn registers(self) -> (u8, u8) {
        match self {
            // STATUS, RAW ANGLE
            Self::As5600 => (0x36, 0x0b),
            // Diagnostics, magnitude, angle
            Self::As5048b => (0x40, 0xfb),
        }
    }

    /// Returns the angle in these registers.
    ///
    /// # Errors
    /// [`Condition::NoMagnet`].
    pub fn decode(self, registers: &[u8; LENGTH]) -> Result<Angle, Condition> {
        let (valid, angle) = match *registers {
            // Bit MD: a magnet was detected. Bits 11 to 0.
            [status, high, low, ..] if self == Self::As5600 => (
                status & 1 << 5 != 0,
                (u32::from(high & 0x0f) << 8 | u32::from(low)) << 20,
            ),
            // Offset compensation finished; no overflow, and the field neither too high nor too
            // low. Bits 13 to 6, and 5 to 0.
            [diagnostics, _, _, high, low] => (
                diagnostics & 0x0f == 1,
                (u32::from(high) << 6 | u32::from(low & 0x3f)) << 18,
            ),
        };
        if valid {
            Ok(Angle::from_bits(angle.cast_signed()))
        } else {
            Err(Condition::NoMagnet)
        }
    }
}
