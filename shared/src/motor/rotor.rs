//! Electrical angle of a three-phase motor from its rotor sensor.

use crate::units::Angle;

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
        let turn = 4_294_967_296_i64 * i64::from(mounting.pole_pairs);
        let counts = i64::from(mounting.counts_per_turn.max(1));
        let per_count = (turn + counts / 2) / counts;
        let direction = if mounting.reversed { -1 } else { 1 };
        Self {
            offset: mounting.offset.0,
            per_count: (per_count * i64::from(direction)) as i32,
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

    /// Returns the sign with which a current in q turns the rotor towards larger counts.
    #[inline]
    pub fn direction(&self) -> i32 {
        self.direction
    }
}

impl ElectricalAngle {
    /// Creates an angle from thousandths of a degree.
    pub fn from_milli_degrees(milli_degrees: i32) -> Self {
        let bits = i64::from(milli_degrees) * 4_294_967_296 / 360_000;
        Self(Angle::from_bits(bits as i32))
    }
}
