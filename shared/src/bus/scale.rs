//! Units of the integers on the bus: one scale per kind of axle for positions, velocities and loads
//! of its output shaft, and decimal fractions of SI units for everything else.

use crate::math::{Turns, saturate, to_i16, to_i32};
use crate::settings::SCHEMA_VERSION;
use crate::units::{Angle, Length};

/// Scale of the objects for position and velocity: 0x6064, 0x606C, 0x607A and 0x60FF.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Scale {
    /// A turning axle: positions in 2^-`bits` turn, velocities in 1e-6 rad/s.
    Turning {
        /// Fraction bits of a turn, 8 to 32. The position wraps on the bus after 2^(32 - `bits`)
        /// turns.
        bits: u32,
    },
    /// A screw: positions in 2^-24 m of extension, velocities in 1e-9 m/s. [`Scale::linear`]
    /// creates it.
    Linear(Lead),
}

/// Lead of a screw (its travel per turn of the output shaft), prepared for use without division.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Lead {
    /// Travel per turn, 2^-32 m. It is below 2^31, because a lead is shorter than half a metre.
    metres_q32: i32,
    /// Turns per travel: 2^-32 turn per 2^-28 m, with 16 fraction bits.
    turns_q16: i64,
    /// Largest length, 2^-28 m, whose number of turns fits into 64 bits.
    reach: i64,
    /// Angle of the shaft per travel, rad/m.
    radians_per_metre: f32,
    /// Bus units (1e-9 m/s) per rad/s of the shaft.
    velocity_units: f32,
}

/// Fraction bits of a metre in a screw's position on the bus.
const LENGTH_BITS: u16 = 24;

/// Bus units (1e-6 rad/s) per rad/s of a turning axle.
const TURNING_UNITS: f32 = 1e6;

/// Position of an output shaft as the bus carries it. It is exact. Although it wraps, its distance
/// from an earlier position can be computed.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Position {
    wire: i32,
    /// Turns or metres per bit; a power of two.
    unit: f32,
}

impl Position {
    /// Returns the angle, rad, of the wrapped position. Worst error: half a unit in the last place.
    pub fn radians(self) -> f32 {
        self.wire as f32 * (self.unit * core::f32::consts::TAU)
    }

    /// Returns the length of a screw, m.
    pub fn metres(self) -> f32 {
        self.wire as f32 * self.unit
    }

    /// Returns the angle of a shaft whose position counts in 2^-32 turn.
    pub fn angle(self) -> Angle {
        Angle::from_bits(self.wire)
    }

    /// Returns the turns since `before`, exact up to 2^24 bits. The result is right while it is
    /// below half of the turns after which the position wraps. It is 0 if `before` is the default,
    /// which means that no position was received.
    pub fn turns_since(self, before: Self) -> f32 {
        self.wire.wrapping_sub(before.wire) as f32 * before.unit
    }
}

/// Target position of a drive.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Target {
    /// Angle of a turning axle, exact.
    Angle(Angle),
    /// Angle of a turning axle, rad.
    Radians(f32),
    /// Length of a screw, exact to 2^-24 m.
    Length(Length),
}

/// Converts between the bus units of one drive and radians or metres: a [`Scale`] that is prepared
/// for use in every tick.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct BusUnits {
    /// The axle is a screw.
    linear: bool,
    /// Fraction bits of a turn or a metre.
    bits: u32,
    /// Turns or metres per bit.
    position: f32,
    /// Bus units per rad/s.
    velocity: f32,
}

impl BusUnits {
    /// Interprets `wire` as a position in bus units.
    #[inline]
    pub fn position(&self, wire: i32) -> Position {
        Position {
            wire,
            unit: self.position,
        }
    }

    /// Converts a target to bus units. Saturates; 0 for NaN. `None` for an angle of a screw and for
    /// a length of a turning axle.
    #[inline]
    pub fn target(&self, target: Target) -> Option<i32> {
        match (target, self.linear) {
            (Target::Angle(angle), false) => Some(angle.to_bits() >> (32 - self.bits)),
            (Target::Radians(angle), false) => {
                Some(to_i32(angle / (self.position * core::f32::consts::TAU)))
            }
            (Target::Length(length), true) => {
                Some(length.to_bits() >> (Length::FRAC_NBITS - self.bits))
            }
            _ => None,
        }
    }

    /// Converts a length in m to bus units. Saturates; 0 for NaN. `None` for a turning axle.
    #[inline]
    pub fn length(&self, metres: f32) -> Option<i32> {
        self.linear.then(|| to_i32(metres / self.position))
    }

    /// Converts the load of the output shaft to bus units: a torque in N m, for a screw a force in
    /// N. Saturates; 0 for NaN.
    pub fn load(&self, load: f32) -> i16 {
        if self.linear {
            to_i16(load)
        } else {
            centi(load)
        }
    }

    /// Converts a velocity of the output shaft, rad/s, to bus units. Saturates; 0 for NaN.
    #[inline]
    pub fn velocity(&self, velocity: f32) -> i32 {
        to_i32(velocity * self.velocity)
    }
}

/// Converts to thousandths: mm, mm/s, mrad/s or mA. Saturates; 0 for NaN.
pub fn milli(value: f32) -> i16 {
    to_i16(value * 1e3)
}

/// Converts a height in m to the nearest word in millimetres.
pub fn millimetres(metres: f32) -> i16 {
    let word = metres * 1e3;
    to_i16(word + f32::copysign(0.5, word))
}

/// Converts thousandths to units.
pub fn from_milli(word: i16) -> f32 {
    f32::from(word) * 1e-3
}

/// Converts to thousandths of 32 bits: mm or mV. Saturates; 0 for NaN.
pub fn milli_i32(value: f32) -> i32 {
    to_i32(value * 1e3)
}

/// Converts to millionths: um. Saturates; 0 for NaN.
pub fn micro(value: f32) -> i32 {
    to_i32(value * 1e6)
}

/// Converts to tenths: 0.1 degree Celsius. Saturates; 0 for NaN.
pub fn deci(value: f32) -> i16 {
    to_i16(value * 10.0)
}

/// Converts to hundredths: cm, percent, 0.01 m/s^2 or 0.01 N m. Saturates; 0 for NaN.
pub fn centi(value: f32) -> i16 {
    to_i16(value * 100.0)
}

/// Converts hundredths to units.
pub fn from_centi(word: i16) -> f32 {
    f32::from(word) * 0.01
}

/// Converts an angle, rad, to hundredths of a degree. Saturates; 0 for NaN.
pub fn centidegrees(radians: f32) -> i16 {
    centi(radians.to_degrees())
}

/// Bit of object 0x2010 of a drive that has no settings besides its node id, that refused some, or
/// whose save was interrupted.
pub const UNCONFIGURED: u16 = 1 << 15;

impl Scale {
    /// Fraction bits of a turn or a metre.
    fn bits(&self) -> u32 {
        match self {
            Self::Turning { bits } => *bits,
            Self::Linear(_) => u32::from(LENGTH_BITS),
        }
    }

    /// Returns this scale, prepared for use in every tick.
    pub fn units(&self) -> BusUnits {
        let bits = self.bits();
        BusUnits {
            linear: matches!(self, Self::Linear(_)),
            bits,
            // 2^-bits, made from the exponent of a float.
            position: f32::from_bits((127 - bits) << 23),
            velocity: self.velocity_units(),
        }
    }

    /// Creates the scale of a screw with this lead, um per turn. A lead outside of 1 um to 0.499999
    /// m is limited to this range.
    pub fn linear(lead_um: i32) -> Self {
        let lead_um = i64::from(lead_um.clamp(1, 499_999));
        let metres = lead_um as f32 * 1e-6;
        let turns_q16 = (16_000_000 << 16) / lead_um;
        Self::Linear(Lead {
            metres_q32: ((lead_um << 32) / 1_000_000) as i32,
            turns_q16,
            reach: i64::MAX / turns_q16,
            radians_per_metre: core::f32::consts::TAU / metres,
            velocity_units: metres * (1e9 / core::f32::consts::TAU),
        })
    }

    /// Returns the code of this position scale (object 0x2010): the fraction bits of a turn; for a
    /// screw, 0x100 plus the fraction bits of a metre. Bits 12 to 14 are the version of the table
    /// of settings, minus 1: a drive with another table does not mean the same by its settings.
    pub fn code(self) -> u16 {
        let scale = match self {
            Self::Turning { bits } => bits as u16,
            Self::Linear(_) => 0x100 | LENGTH_BITS,
        };
        scale | ((SCHEMA_VERSION - 1) & 7) << 12
    }

    /// Converts a position of the output shaft to bus units. Wraps for a turning axle,
    /// saturates for a screw.
    pub fn position_to_bus(self, position: Turns) -> i32 {
        match self {
            Self::Turning { bits } => (position.to_bits() >> (32 - bits)) as i32,
            Self::Linear(_) => saturate(self.distance_to_bus(position)),
        }
    }

    /// Converts bus units to a position of the output shaft. A wrapped position gives
    /// the shaft position nearest to `near`.
    pub fn position_from_bus(self, wire: i32, near: Turns) -> Turns {
        match self {
            Self::Turning { bits } => {
                let shift = 32 - bits;
                let difference = wire.wrapping_sub(self.position_to_bus(near));
                let units = (near.to_bits() >> shift).wrapping_add(i64::from(difference));
                Turns::from_bits(units << shift)
            }
            Self::Linear(_) => self.shaft_from_length(i64::from(wire) << 4),
        }
    }

    /// Converts a distance on the output shaft to bus units. It does not wrap.
    pub fn distance_to_bus(self, distance: Turns) -> i64 {
        match self {
            Self::Turning { bits } => distance.to_bits() >> (32 - bits),
            Self::Linear(lead) => {
                // 2^-24 turn times 2^-32 m per turn, reduced to 2^-24 m.
                let (turns, scale) = (distance.to_bits() >> 8, i64::from(lead.metres_q32));
                (turns >> 32) * scale + (((turns & 0xffff_ffff) * scale) >> 32)
            }
        }
    }

    /// Converts a distance of at most 2^32 bus units to a distance on the output shaft. It does
    /// not wrap.
    pub fn distance_from_bus(self, distance: i64) -> Turns {
        match self {
            Self::Turning { bits } => Turns::from_bits(distance << (32 - bits)),
            Self::Linear(_) => self.shaft_from_length(distance << 4),
        }
    }

    /// Converts a length, 2^-28 m, to a position of the output shaft. 0 for a turning axle, which
    /// has no length.
    pub fn shaft_from_length(self, length_q28: i64) -> Turns {
        match self {
            Self::Turning { .. } => Turns::ZERO,
            Self::Linear(lead) => {
                let length = if length_q28 > lead.reach {
                    lead.reach
                } else if length_q28 < -lead.reach {
                    -lead.reach
                } else {
                    length_q28
                };
                Turns::from_bits((length * lead.turns_q16) >> 16)
            }
        }
    }

    /// Converts a velocity of the nut, m/s, to a velocity of the output shaft, rad/s. 0 for a
    /// turning axle.
    pub fn shaft_velocity_from_linear(self, velocity: f32) -> f32 {
        match self {
            Self::Turning { .. } => 0.0,
            Self::Linear(lead) => velocity * lead.radians_per_metre,
        }
    }

    /// Converts a velocity of the output shaft, rad/s, to bus units. Saturates; 0 for NaN.
    pub fn velocity_to_bus(self, velocity: f32) -> i32 {
        to_i32(velocity * self.velocity_units())
    }

    /// Converts bus units to a velocity of the output shaft, rad/s.
    pub fn velocity_from_bus(self, wire: i32) -> f32 {
        wire as f32 / self.velocity_units()
    }

    /// Returns the velocity, rad/s, or acceleration, rad/s^2, of a profile: infinite for
    /// `u32::MAX`.
    pub fn profile_from_bus(self, wire: u32) -> f32 {
        if wire == u32::MAX {
            f32::INFINITY
        } else {
            wire as f32 / self.velocity_units()
        }
    }

    /// Returns the bus units of torque per N m at the output shaft. The unit of a turning axle is
    /// 0.01 N m of torque, that of a screw 1 N of force.
    pub fn torque_units(self) -> f32 {
        match self {
            Self::Turning { .. } => 100.0,
            Self::Linear(lead) => lead.radians_per_metre,
        }
    }

    fn velocity_units(&self) -> f32 {
        match self {
            Self::Turning { .. } => TURNING_UNITS,
            Self::Linear(lead) => lead.velocity_units,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_position_returns_within_one_unit() {
        let scale = Scale::linear(5_000);
        for um in [-1_000_i64, 0, 220_000, 226_017, 620_000] {
            let wire = (um << 24) / 1_000_000;
            let there = scale.position_from_bus(wire as i32, Turns::ZERO);
            let turns = there.to_bits() as f64 / 4_294_967_296.0;
            assert!((turns * 5e-3 - wire as f64 / 16_777_216.0).abs() < 1e-9);
            assert!((i64::from(scale.position_to_bus(there)) - wire).abs() <= 1);
        }
    }

    #[test]
    fn a_turning_position_is_found_again_across_its_wrap() {
        let scale = Scale::Turning { bits: 16 };
        let near = Turns::from_bits(32_767 << 32);
        let wanted = near + Turns::from_bits(3 << 32);
        let wire = scale.position_to_bus(wanted);
        assert!(wire < 0, "the position has wrapped on the bus");
        assert_eq!(scale.position_from_bus(wire, near), wanted);
    }

    #[test]
    fn velocities_are_micro_radians_and_nanometres_per_second() {
        assert_eq!(Scale::Turning { bits: 32 }.velocity_to_bus(0.5), 500_000);
        let screw = Scale::linear(5_000);
        let one_turn_a_second = screw.velocity_to_bus(core::f32::consts::TAU);
        assert!(
            (one_turn_a_second - 5_000_000).abs() <= 1,
            "{one_turn_a_second}"
        );
        assert_eq!(screw.velocity_to_bus(f32::NAN), 0);
    }

    #[test]
    fn a_target_of_another_kind_of_axle_is_none() {
        let (turning, screw) = (
            Scale::Turning { bits: 32 }.units(),
            Scale::linear(5_000).units(),
        );
        let (angle, length) = (Angle::from_bits(1), Length::from_bits(16));
        assert_eq!(turning.target(Target::Angle(angle)), Some(1));
        assert_eq!(screw.target(Target::Length(length)), Some(1));
        assert_eq!(turning.target(Target::Length(length)), None);
        assert_eq!(screw.target(Target::Angle(angle)), None);
        assert_eq!(screw.target(Target::Radians(0.1)), None);
    }

    #[test]
    fn a_position_that_was_never_received_is_no_beginning_of_a_way() {
        let units = Scale::Turning { bits: 16 }.units();
        let far = units.position(1_000_000);
        assert_eq!(far.turns_since(Position::default()), 0.0);
        assert_eq!(far.turns_since(units.position(1_000_000 - 65_536)), 1.0);
    }
}
