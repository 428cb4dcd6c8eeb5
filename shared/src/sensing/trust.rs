//! How far the body sensors are trusted, and why not, with the codes on the bus.

/// Fault of the body sensors.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reason {
    /// No reading was received in time.
    Silent = 1,
    /// Readings are not finite.
    NotFinite = 2,
    /// Readings are beyond the range of such a sensor.
    OutOfRange = 3,
    /// A reading repeats bit-identically although the sensor is noisy or the robot moves.
    Stuck = 4,
    /// The specific force of a slow robot deviates from 1 g for too long.
    OffGravity = 5,
    /// Accelerometer and attitude filter (gyroscope and inclinometer) disagree on the vertical.
    Disagreement = 6,
    /// The sensor measures less often than its setting says.
    Slow = 7,
    /// The readings jump back and forth more than any motion of the robot.
    Noisy = 8,
    /// Every axis of the accelerometer reads zero.
    Zero = 9,
    /// The sensor is upside down.
    UpsideDown = 10,
    /// The specific force is that of a robot that falls freely.
    FreeFall = 11,
}

impl Reason {
    /// Returns the reason with this number.
    pub fn from_byte(byte: u8) -> Option<Self> {
        use Reason::{Disagreement, FreeFall, Noisy, NotFinite, OffGravity, OutOfRange};
        use Reason::{Silent, Slow, Stuck, UpsideDown, Zero};
        [
            Silent,
            NotFinite,
            OutOfRange,
            Stuck,
            OffGravity,
            Disagreement,
            Slow,
            Noisy,
            Zero,
            UpsideDown,
            FreeFall,
        ]
        .into_iter()
        .find(|reason| *reason as u8 == byte)
    }

    /// Text in logs and reports.
    pub fn words(self) -> &'static str {
        match self {
            Self::Silent => "sensors silent",
            Self::NotFinite => "sensors not finite",
            Self::OutOfRange => "sensors out of range",
            Self::Stuck => "sensor stuck",
            Self::OffGravity => "force is not gravity",
            Self::Disagreement => "sensors disagree",
            Self::Slow => "sensor too slow",
            Self::Noisy => "sensor too noisy",
            Self::Zero => "sensor reads zero",
            Self::UpsideDown => "sensor upside down",
            Self::FreeFall => "free fall",
        }
    }
}

/// Trust in the body sensors.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Trust {
    /// The sensors are trusted.
    Full,
    /// The sensors are in doubt: the robot may go on slowly.
    Degraded(Reason),
    /// The sensors are not trusted: nothing passes.
    None(Reason),
}

impl Trust {
    /// Code in object 0x4006:2: 0, or 0x10 (degraded) or 0x20 (none) with the reason.
    pub fn code(self) -> u8 {
        match self {
            Self::Full => 0,
            Self::Degraded(reason) => 0x10 | reason as u8,
            Self::None(reason) => 0x20 | reason as u8,
        }
    }

    /// Returns the trust with this code, if there is one.
    pub fn from_code(code: u8) -> Option<Self> {
        if code == 0 {
            return Some(Self::Full);
        }
        let reason = Reason::from_byte(code & 0x0f)?;
        match code >> 4 {
            1 => Some(Self::Degraded(reason)),
            2 => Some(Self::None(reason)),
            _ => None,
        }
    }

    /// The worse of two: none is worse than degraded. The first if both are equally bad.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        if other.code() >> 4 > self.code() >> 4 {
            other
        } else {
            self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_survive() {
        for code in 0..=0xff_u8 {
            if let Some(trust) = Trust::from_code(code) {
                assert_eq!(trust.code(), code);
            }
        }
        assert_eq!(Trust::from_code(0x24), Some(Trust::None(Reason::Stuck)));
        assert_eq!(Trust::from_code(0x17), Some(Trust::Degraded(Reason::Slow)));
    }
}
