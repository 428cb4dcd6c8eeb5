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

struct Record {
    condition: AtomicU8,
    errors: AtomicU16,
}

static RECORDS: [Record; Chip::ALL.len()] = [const {
    Record {
        condition: AtomicU8::new(Condition::Absent as u8),
        errors: AtomicU16::new(0),
    }
}; Chip::ALL.len()];

/// Code of a chip's [`Condition`].
pub fn code(chip: Chip) -> u8 {
    RECORDS[chip as usize].condition.load(Ordering::Relaxed)
}

/// Number of a chip's errors since power-up; it stops at its maximum.
pub fn errors(chip: Chip) -> u16 {
    RECORDS[chip as usize].errors.load(Ordering::Relaxed)
}

/// Records and logs a chip's condition, if it has changed.
pub(super) fn set(chip: Chip, condition: Condition) {
    let record = &RECORDS[chip as usize].condition;
    if record.load(Ordering::Relaxed) == condition as u8 {
        return;
    }
    record.store(condition as u8, Ordering::Relaxed);
    if condition == Condition::Running {
        crate::logger::info!("{}: {}", chip.name(), condition.words());
    } else {
        crate::logger::warn!("{}: {}", chip.name(), condition.words());
    }
}

/// Counts an error of a chip. Only one task does.
pub(super) fn count_error(chip: Chip) {
    let record = &RECORDS[chip as usize].errors;
    record.store(
        record.load(Ordering::Relaxed).saturating_add(1),
        Ordering::Relaxed,
    );
}
