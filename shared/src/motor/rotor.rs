//! Electrical angle of a three-phase motor from its rotor sensor.

use crate::settings::{Setting, Settings};
use crate::units::Angle;
use core::num::NonZeroU32;

/// Rotor sensor of a three-phase motor, as `rotor_sensor` numbers it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum RotorSensor {
    /// Absolute within a turn.
    Absolute = 0,
    /// Incremental encoder.
    Incremental = 1,
    /// Absolute within a turn, checked at arming.
    Checked = 2,
    /// Incremental encoder with an index.
    Indexed = 3,
    /// Three Hall sensors ([`super::halls`]).
    Halls = 4,
    /// The same, checked at arming.
    CheckedHalls = 5,
}

impl RotorSensor {
    /// Reads the sensor from the settings; `None` for a brushed motor.
    pub fn of(settings: &Settings) -> Option<Self> {
        if settings.get(Setting::MotorKind) == 0 {
            return None;
        }
        Some(match settings.get(Setting::RotorSensor) {
            1 => Self::Incremental,
            2 => Self::Checked,
            3 => Self::Indexed,
            4 => Self::Halls,
            5 => Self::CheckedHalls,
            _ => Self::Absolute,
        })
    }

    /// Whether arming aligns the rotor.
    pub fn needs_alignment(self) -> bool {
        !matches!(self, Self::Absolute | Self::Halls)
    }

    /// Whether an alignment only checks an angle that is known.
    pub fn is_checked(self) -> bool {
        matches!(self, Self::Checked | Self::CheckedHalls)
    }

    /// Whether Hall sensors show the rotor.
    pub fn has_halls(self) -> bool {
        matches!(self, Self::Halls | Self::CheckedHalls)
    }
}

/// Electrical angle. It makes one turn per pole pair and must not be confused with the mechanical
/// angle of the rotor.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct ElectricalAngle(pub Angle);

/// How a rotor sensor is mounted, and what one of its counts means.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Mounting {
    /// Counts per turn of the rotor, 4 to 2^20.
    pub counts_per_turn: i32,
    /// Pole pairs of the motor, 1 to 64.
    pub pole_pairs: i32,
    /// Electrical angle at count 0.
    pub offset: ElectricalAngle,
    /// The electrical angle falls while the counts rise: two leads of the motor are swapped.
    pub reversed: bool,
}

/// Converts the count of a rotor sensor to the electrical angle.
#[derive(Clone, Copy, Debug)]
pub struct Rotor {
    offset: Angle,
    /// Electrical angle per count, 2^-32 turn.
    per_count: i32,
    /// Sign with which a current in q turns the rotor towards larger counts.
    direction: i32,
}

impl Rotor {
    /// Creates the conversion.
    pub fn new(mounting: Mounting) -> Self {
        let per_count = per_count(mounting.pole_pairs, mounting.counts_per_turn);
        let direction = if mounting.reversed { -1 } else { 1 };
        Self {
            offset: mounting.offset.0,
            per_count: per_count.wrapping_mul(direction),
            direction,
        }
    }

    /// Returns the electrical angle at `count`, the sensor's count within a turn.
    ///
    /// Error: at most half a unit of 2^-32 turn per count, thus below 2^-12 turn for 2^20 counts.
    #[inline]
    pub fn angle(&self, count: u32) -> ElectricalAngle {
        let turned = (count as i32).wrapping_mul(self.per_count);
        ElectricalAngle(self.offset + Angle::from_bits(turned))
    }

    /// Returns the angle of the axes in which a positive current in q, turned by
    /// [`Self::direction`], points along `field`.
    pub fn axes_of_field(&self, field: ElectricalAngle) -> ElectricalAngle {
        ElectricalAngle(field.0 - self.quarter())
    }

    /// Returns the field to which these axes belong ([`Self::axes_of_field`]).
    pub fn field_of_axes(&self, axes: ElectricalAngle) -> ElectricalAngle {
        ElectricalAngle(axes.0 + self.quarter())
    }

    fn quarter(&self) -> Angle {
        Angle::from_bits(self.direction << 30)
    }

    /// Adds `error` to the angle of every count.
    pub fn correct(&mut self, error: ElectricalAngle) {
        self.offset += error.0;
    }

    /// Returns the sign with which a current in q turns the rotor towards larger counts.
    #[inline]
    pub fn direction(&self) -> i32 {
        self.direction
    }
}

/// Follows the count of a rotor sensor within a turn. So the rounding of [`Rotor::angle`] does not
/// add up over the turns of an incremental encoder, whose count goes on from turn to turn.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    counts: i32,
    within: i32,
    last: u32,
}

impl Turn {
    /// Creates a turn that begins at count 0.
    pub fn new(mounting: Mounting) -> Self {
        Self {
            counts: mounting.counts_per_turn,
            within: 0,
            last: 0,
        }
    }

    /// Returns the count within a turn for this reading of the sensor. A reading that is within a
    /// turn already is returned as it is. The sensor moves by less than a turn between two calls;
    /// after a longer pause, the next calls return to the turn one by one.
    #[inline]
    pub fn update(&mut self, reading: u32) -> u32 {
        let moved = reading.wrapping_sub(self.last) as i32;
        self.last = reading;
        let count = self.within.wrapping_add(moved);
        self.within = if count >= self.counts {
            count - self.counts
        } else if count < 0 {
            count + self.counts
        } else {
            count
        };
        self.within as u32
    }

    /// Returns the count of the last reading within a turn.
    pub fn count(&self) -> u32 {
        self.within as u32
    }

    /// Returns the last reading.
    pub fn reading(&self) -> u32 {
        self.last
    }

    /// Returns the count within a turn of any `reading`, which need not be near the last one.
    pub fn within(&self, reading: u32) -> u32 {
        let moved = reading.wrapping_sub(self.last) as i32;
        // Both are below a turn. The number of counts per turn is not zero.
        let moved = moved.checked_rem_euclid(self.counts).unwrap_or(0);
        (self.within + moved)
            .checked_rem_euclid(self.counts)
            .unwrap_or(0) as u32
    }
}

impl ElectricalAngle {
    /// Creates an angle from thousandths of a degree, rounded towards 0.
    pub fn from_milli_degrees(milli_degrees: i32) -> Self {
        // 2^32 / 360 000 is 2^26 / 5625, in two divisions of 32 bits.
        let size = milli_degrees.unsigned_abs() % 360_000;
        let (high, rest) = ((size << 13) / 5_625, (size << 13) % 5_625);
        let bits = ((high << 13) + (rest << 13) / 5_625) as i32;
        Self(Angle::from_bits(if milli_degrees < 0 {
            bits.wrapping_neg()
        } else {
            bits
        }))
    }
}

/// Electrical angle per count, 2^-32 turn, rounded and wrapped. It divides in steps of 32 bits,
/// because a calibration computes it in the control task.
fn per_count(pole_pairs: i32, counts_per_turn: i32) -> i32 {
    let counts = NonZeroU32::new(counts_per_turn.unsigned_abs()).unwrap_or(NonZeroU32::MIN);
    let (mut quotient, mut rest) = (0_u32, pole_pairs.unsigned_abs());
    quotient = quotient.wrapping_add(rest / counts);
    rest %= counts;
    // The rest is below 2^20.
    for bits in [11, 11, 10] {
        rest <<= bits;
        quotient = (quotient << bits).wrapping_add(rest / counts);
        rest %= counts;
    }
    quotient.wrapping_add(u32::from(rest >= counts.get().div_ceil(2))) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn divisions_of_32_bits_give_the_same_as_one_of_64_bits() {
        for pole_pairs in 1..=64 {
            for counts in (4..2_000).chain([4_095, 4_096, 65_537, 999_983, 1 << 20]) {
                let turn = i64::from(pole_pairs) << 32;
                let expected = (turn + i64::from(counts) / 2) / i64::from(counts);
                assert_eq!(per_count(pole_pairs, counts), expected as i32, "{counts}");
            }
        }
        for milli_degrees in (-400_000..=400_000).step_by(7) {
            let expected = i64::from(milli_degrees) * 4_294_967_296 / 360_000;
            let angle = ElectricalAngle::from_milli_degrees(milli_degrees);
            assert_eq!(angle.0.to_bits(), expected as i32, "{milli_degrees}");
        }
    }

    #[test]
    fn a_turn_loses_no_angle_in_a_hundred_million_counts() {
        // 2^32 * 7 / 2000 is no whole number.
        let mounting = Mounting {
            counts_per_turn: 2_000,
            pole_pairs: 7,
            offset: ElectricalAngle::default(),
            reversed: false,
        };
        let (rotor, mut turn) = (Rotor::new(mounting), Turn::new(mounting));
        let (mut count, mut worst) = (0_i64, 0);
        for step in 0..2_000_000_i64 {
            count += if step < 1_200_000 { 97 } else { -150 };
            let angle = rotor.angle(turn.update(count as u32)).0;
            let exact = (i128::from(count) * 7 * (1 << 32)).div_euclid(2_000) as i32;
            worst = worst.max(angle.to_bits().wrapping_sub(exact).unsigned_abs());
            assert!(i64::from(turn.count()) == count.rem_euclid(2_000));
        }
        assert!(worst <= 1_000, "{worst} units of 2^-32 turn");
    }
}
