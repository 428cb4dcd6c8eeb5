//! How positions and velocities of the output shaft appear on the bus: one scale per kind of axle.

use crate::math::{saturate, to_i32};
use crate::units::{Angle, Length};

/// Scale of objects 0x6064, 0x606C, 0x607A and 0x60FF.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Scale {
    /// A turning axle: 2^-`bits` turn and 1e-6 rad/s.
    Turning {
        /// Fraction bits of a turn, 8 to 32; the position wraps on the bus after 2^(32 - `bits`) turns.
        bits: u32,
    },
    /// A screw: 2^-24 m of extension and 1e-9 m/s. Made by [`Scale::linear`].
    Linear(Lead),
}

/// Travel of a screw per turn of the output shaft, prepared for use without division.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Lead {
    /// 2^-32 m per turn; below 2^31, because a lead is shorter than half a metre.
    metres_q32: i32,
    /// 2^-32 turn per 2^-28 m, in 2^-16.
    turns_q16: i64,
    /// Longest length, 2^-28 m, whose turns can be expressed.
    reach: i64,
    /// rad/m.
    radians_per_metre: f32,
    /// rad/s as 1e-9 m/s.
    velocity_units: f32,
}

/// Fraction bits of a metre in a screw's position on the bus.
const LENGTH_BITS: u16 = 24;

/// Velocity of a turning axle on the bus: rad/s as 1e-6 rad/s.
const TURNING_UNITS: f32 = 1e6;

/// Position of an output shaft as the bus has it: exact, and comparable with an earlier one although
/// it wraps.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Position {
    wire: i32,
    /// Turns or metres of one bit: a power of two.
    unit: f32,
}

impl Position {
    /// rad, by the wrapped position; worst error half an ulp.
    pub fn radians(self) -> f32 {
        self.wire as f32 * (self.unit * core::f32::consts::TAU)
    }

    /// Length of a screw, m.
    pub fn metres(self) -> f32 {
        self.wire as f32 * self.unit
    }

    /// Angle of a shaft that counts in 2^-32 turn.
    pub fn angle(self) -> Angle {
        Angle::from_bits(self.wire)
    }

    /// Turns since `before`, exact up to 2^24 bits; right as long as they are less than half of those
    /// after which the position wraps. 0 if `before` is the default, which was never received.
    pub fn turns_since(self, before: Self) -> f32 {
        self.wire.wrapping_sub(before.wire) as f32 * before.unit
    }
}

/// A position that a drive is sent to.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Target {
    /// Of a turning axle, exact.
    Angle(Angle),
    /// Of a turning axle, rad.
    Radians(f32),
    /// Of a screw, exact to 2^-24 m.
    Length(Length),
}

/// Units of one drive on the bus, for those who count in radians and metres: a [`Scale`] that is
/// prepared for use in every tick.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct BusUnits {
    /// The axle is a screw.
    linear: bool,
    /// Fraction bits of a turn or a metre.
    bits: u32,
    /// Turns or metres of one bit.
    position: f32,
    /// Bus units of 1 rad/s.
    velocity: f32,
}

impl BusUnits {
    /// A position in bus units.
    #[inline]
    pub fn position(&self, wire: i32) -> Position {
        Position {
            wire,
            unit: self.position,
        }
    }

    /// A target in bus units; saturates, 0 for NaN. None if it is an angle for a screw or a length for
    /// a turning axle.
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

    /// A velocity of the output shaft (rad/s) in bus units; saturates, 0 for NaN.
    #[inline]
    pub fn velocity(&self, velocity: f32) -> i32 {
        to_i32(velocity * self.velocity)
    }
}

impl Scale {
    /// Fraction bits of a turn or a metre.
    fn bits(&self) -> u32 {
        match self {
            Self::Turning { bits } => *bits,
            Self::Linear(_) => u32::from(LENGTH_BITS),
        }
    }

    /// The same, prepared for use in every tick.
    pub fn units(&self) -> BusUnits {
        let bits = self.bits();
        BusUnits {
            linear: matches!(self, Self::Linear(_)),
            bits,
            // 2^-bits, by the exponent of a float.
            position: f32::from_bits((127 - bits) << 23),
            velocity: self.velocity_units(),
        }
    }

    /// Scale of a screw with this lead in um per turn, above zero and below half a metre.
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

    /// Number of this position scale (object 0x2010): the fraction bits of a turn; for a screw, 0x100
    /// and the fraction bits of a metre.
    pub fn code(self) -> u16 {
        match self {
            Self::Turning { bits } => bits as u16,
            Self::Linear(_) => 0x100 | LENGTH_BITS,
        }
    }

    /// Position of the output shaft (2^-32 turn) in bus units; wraps when turning, saturates when linear.
    pub fn position_to_bus(self, position: i64) -> i32 {
        match self {
            Self::Turning { bits } => (position >> (32 - bits)) as i32,
            Self::Linear(lead) => {
                // 2^-24 turn times 2^-32 m per turn, down to 2^-24 m.
                let (turns, scale) = (position >> 8, i64::from(lead.metres_q32));
                let metres = (turns >> 32) * scale + (((turns & 0xffff_ffff) * scale) >> 32);
                saturate(metres)
            }
        }
    }

    /// Bus units as a position of the output shaft near `near`: a wrapped position is taken as the nearest one.
    pub fn position_from_bus(self, wire: i32, near: i64) -> i64 {
        match self {
            Self::Turning { bits } => {
                let shift = 32 - bits;
                let difference = wire.wrapping_sub(self.position_to_bus(near));
                ((near >> shift).wrapping_add(i64::from(difference))) << shift
            }
            Self::Linear(_) => self.shaft_from_length(i64::from(wire) << 4),
        }
    }

    /// Position of the output shaft for a length in 2^-28 m; 0 for a turning axle, which has no length.
    pub fn shaft_from_length(self, length_q28: i64) -> i64 {
        match self {
            Self::Turning { .. } => 0,
            Self::Linear(lead) => {
                let length = if length_q28 > lead.reach {
                    lead.reach
                } else if length_q28 < -lead.reach {
                    -lead.reach
                } else {
                    length_q28
                };
                (length * lead.turns_q16) >> 16
            }
        }
    }

    /// Velocity of the output shaft (rad/s) for a velocity of the nut in m/s; 0 for a turning axle.
    pub fn shaft_velocity_from_linear(self, velocity: f32) -> f32 {
        match self {
            Self::Turning { .. } => 0.0,
            Self::Linear(lead) => velocity * lead.radians_per_metre,
        }
    }

    /// Velocity of the output shaft (rad/s) in bus units; saturates, 0 for NaN.
    pub fn velocity_to_bus(self, velocity: f32) -> i32 {
        to_i32(velocity * self.velocity_units())
    }

    /// Bus units as a velocity of the output shaft, rad/s.
    pub fn velocity_from_bus(self, wire: i32) -> f32 {
        wire as f32 / self.velocity_units()
    }

    /// Bus units per N m of the output shaft: of torque 0.01 N m, of the screw's force N.
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
            let there = scale.position_from_bus(wire as i32, 0);
            let turns = there as f64 / 4_294_967_296.0;
            assert!((turns * 5e-3 - wire as f64 / 16_777_216.0).abs() < 1e-9);
            assert!((i64::from(scale.position_to_bus(there)) - wire).abs() <= 1);
        }
    }

    #[test]
    fn a_turning_position_is_found_again_across_its_wrap() {
        let scale = Scale::Turning { bits: 16 };
        let near = 32_767_i64 << 32;
        let wanted = near + (3_i64 << 32);
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
