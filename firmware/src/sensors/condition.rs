//! How each sensor chip does: its condition, and the number of its errors.

use core::sync::atomic::{AtomicU8, AtomicU16, Ordering};

/// Chip of the sensors on the robot's body, in the order of the objects 0x2112 and 0x2113.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Chip {
    /// Inertial unit: accelerometer and gyroscope.
    InertialUnit = 0,
    /// Magnetometer.
    Magnetometer = 1,
    /// Inclinometer.
    Inclinometer = 2,
}

impl Chip {
    /// All chips, in order.
    pub const ALL: [Self; 3] = [Self::InertialUnit, Self::Magnetometer, Self::Inclinometer];

    /// Name in logs and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::InertialUnit => "inertial unit",
            Self::Magnetometer => "magnetometer",
            Self::Inclinometer => "inclinometer",
        }
    }
}

/// Condition of a chip, with its code in object 0x2112.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Condition {
    /// The board has no such chip, or its task has not begun.
    Absent = 0,
    /// The chip was started and is being read.
    Running = 1,
    /// No chip acknowledges the address.
    NoAcknowledge = 2,
    /// A transfer did not end in time: a line of the bus is held low.
    BusStuck = 3,
    /// The bus had another error.
    BusError = 4,
    /// The chip has another identity than expected.
    WrongIdentity = 5,
    /// The chip was started but has no new readings.
    NoReadings = 6,
}

impl Condition {
    /// Text in logs.
    pub fn words(self) -> &'static str {
        match self {
            Self::Absent => "absent",
            Self::Running => "running",
            Self::NoAcknowledge => "no acknowledge",
            Self::BusStuck => "bus stuck",
            Self::BusError => "bus error",
            Self::WrongIdentity => "wrong identity",
            Self::NoReadings => "no readings",
        }
    }
}

/// Conditions and numbers of errors of the chips.
pub struct Conditions([(AtomicU8, AtomicU16); Chip::ALL.len()]);

impl Conditions {
    /// No chip is there.
    pub(crate) const fn new() -> Self {
        Self(
            [const { (AtomicU8::new(Condition::Absent as u8), AtomicU16::new(0)) };
                Chip::ALL.len()],
        )
    }

    /// Returns code of the [`Condition`], and number of errors since power-up, of each chip. The
    /// number stops at its maximum.
    pub fn codes(&self) -> [(u8, u16); Chip::ALL.len()] {
        Chip::ALL.map(|chip| {
            let (condition, errors) = &self.0[chip as usize];
            (
                condition.load(Ordering::Relaxed),
                errors.load(Ordering::Relaxed),
            )
        })
    }

    /// Whether this is the chip's condition.
    pub(super) fn is(&self, chip: Chip, condition: Condition) -> bool {
        self.0[chip as usize].0.load(Ordering::Relaxed) == condition as u8
    }

    /// Records and logs a chip's condition, if it has changed.
    pub(super) fn set(&self, chip: Chip, condition: Condition) {
        if self.is(chip, condition) {
            return;
        }
        let (record, _) = &self.0[chip as usize];
        record.store(condition as u8, Ordering::Relaxed);
        if condition == Condition::Running {
            crate::logger::info!("{}: {}", chip.name(), condition.words());
        } else {
            crate::logger::warn!("{}: {}", chip.name(), condition.words());
        }
    }

    /// Counts an error of a chip. Only one task does.
    pub(super) fn count_error(&self, chip: Chip) {
        let (_, errors) = &self.0[chip as usize];
        let count = errors.load(Ordering::Relaxed).saturating_add(1);
        errors.store(count, Ordering::Relaxed);
    }
}
