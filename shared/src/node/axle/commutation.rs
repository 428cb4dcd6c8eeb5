//! Alignment of the rotor before operation is enabled. A three-phase motor with an incremental
//! encoder needs it once after power-up, and again after each fault that makes the encoder's count
//! doubtful. With an absolute sensor it is a check, which a setting requests.
//!
//! The drive stays in "switched on" meanwhile, and shows [`status::ALIGNING`]. Whatever ends the
//! request to enable operation ends the alignment, and the bridge opens.
//!
//! [`status::ALIGNING`]: crate::bus::cia402::status::ALIGNING

use super::{Axle, Inputs};
use crate::bus::cia402::{CONTROL_FAULT_RESET, DriveCommand, State};
use crate::faults::{Fault, Faults};
use crate::motor::alignment::{Alignment, Bounds, Observed, Progress};
use crate::motor::index::Finding;
use crate::motor::rotor::{ElectricalAngle, RotorSensor};
use crate::settings::Settings;

/// Faults after which the rotor's angle is not known.
const LOSES_ANGLE: Faults = Faults::of(Fault::VelocityDeviation)
    .or(Faults::of(Fault::EncoderMismatch))
    .or(Faults::of(Fault::RotorAngle))
    .or(Faults::of(Fault::EncoderNoise))
    .or(Faults::of(Fault::Blocked))
    .or(Faults::of(Fault::Misaligned));

/// Whether the rotor's angle is known.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)] // an axle has one of them
enum Knowledge {
    Unknown,
    /// An alignment is under way, with its newest demand.
    Aligning(Alignment, Progress),
    Known,
}

/// Commutation of the motor.
#[derive(Clone, Debug)]
pub(super) struct Commutation {
    /// Bounds of the alignment; `None` if the sensor or the motor needs none.
    bounds: Option<Bounds>,
    knowledge: Knowledge,
    /// The alignment has failed in this tick.
    failed: bool,
    /// The encoder's index has confirmed the angle.
    confirmed: bool,
}

/// State of the commutation, as object 0x2064 shows it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum AlignmentState {
    /// The motor or its sensor needs none.
    NotNeeded = 0,
    /// The rotor is aligned before operation is enabled.
    Needed = 1,
    /// The rotor is being aligned.
    UnderWay = 2,
    /// The rotor's angle is known.
    Done = 3,
    /// The encoder's index has confirmed the angle.
    Confirmed = 4,
}

impl Commutation {
    /// Creates the commutation of an axle at power-up.
    pub fn new(settings: &Settings) -> Self {
        let aligns = RotorSensor::of(settings).is_some_and(RotorSensor::needs_alignment);
        Self {
            bounds: aligns.then(|| Bounds::new(settings)),
            knowledge: Knowledge::Unknown,
            failed: false,
            confirmed: false,
        }
    }

    /// Returns the state for object 0x2064.
    pub fn state(&self) -> AlignmentState {
        match (self.bounds, &self.knowledge) {
            (None, _) => AlignmentState::NotNeeded,
            (_, Knowledge::Unknown) => AlignmentState::Needed,
            (_, Knowledge::Aligning(..)) => AlignmentState::UnderWay,
            (_, Knowledge::Known) if self.confirmed => AlignmentState::Confirmed,
            (_, Knowledge::Known) => AlignmentState::Done,
        }
    }

    /// Returns whether a current can turn the rotor as demanded.
    pub fn knows_angle(&self) -> bool {
        self.bounds.is_none() || matches!(self.knowledge, Knowledge::Known)
    }

    /// Returns whether an alignment is under way.
    #[inline]
    pub fn aligns(&self) -> bool {
        matches!(self.knowledge, Knowledge::Aligning(..))
    }

    /// Returns what the bridge does for the alignment in this tick, if one is under way.
    #[inline]
    pub fn demand(&self) -> Option<Progress> {
        match &self.knowledge {
            Knowledge::Aligning(_, progress) => Some(*progress),
            _ => None,
        }
    }

    /// Starts an alignment unless the rotor's angle is known, or one is under way. Returns whether
    /// operation must wait for it.
    pub fn start(&mut self) -> bool {
        let Some(bounds) = self.bounds else {
            return false;
        };
        if matches!(self.knowledge, Knowledge::Unknown) {
            let zero = Progress::Drive(0.0, ElectricalAngle::default());
            self.knowledge = Knowledge::Aligning(Alignment::new(bounds), zero);
        }
        self.aligns()
    }

    /// Ends an alignment without a result.
    #[inline]
    pub fn abort(&mut self) {
        if self.aligns() {
            self.knowledge = Knowledge::Unknown;
        }
    }

    /// Returns whether the alignment failed since the last call.
    pub fn take_failure(&mut self) -> bool {
        core::mem::take(&mut self.failed)
    }

    /// Takes what the encoder's index shows. Returns the fault that it proves.
    #[inline]
    pub fn check_index(&mut self, finding: Finding) -> Option<Fault> {
        self.confirmed = finding == Finding::Confirmed;
        match (&self.knowledge, finding) {
            (Knowledge::Known, Finding::Misaligned) => Some(Fault::Misaligned),
            (Knowledge::Known, Finding::Lost) => Some(Fault::EncoderNoise),
            _ => None,
        }
    }

    /// Forgets the rotor's angle if `raised` makes it doubtful.
    #[inline]
    pub fn doubt(&mut self, raised: Faults) {
        if !raised.and(LOSES_ANGLE).is_empty() {
            self.knowledge = Knowledge::Unknown;
        }
    }
}

impl Axle {
    /// Forgets the rotor's angle, because the current loop was replaced.
    pub fn forget_rotor_angle(&mut self) {
        self.commutation.knowledge = Knowledge::Unknown;
    }

    /// Returns whether the bridge drives a current: in operation, or for an alignment.
    pub(super) fn energized(&self) -> bool {
        self.powered() || self.commutation.aligns()
    }

    /// Runs one tick of the alignment. It ends operation's wait when the rotor's angle is known.
    pub(super) fn align(&mut self, inputs: &Inputs) {
        let wanted = self.state == State::SwitchedOn
            && self.newest.command == DriveCommand::EnableOperation
            && self.controlword & CONTROL_FAULT_RESET == 0
            && self.latch.faults().is_empty()
            && self.authority.any(inputs.now_us);
        let position = self.position();
        let Knowledge::Aligning(alignment, progress) = &mut self.commutation.knowledge else {
            return;
        };
        if !wanted {
            self.commutation.abort();
            return;
        }
        if let Progress::Done(_) = progress {
            self.commutation.knowledge = Knowledge::Known;
            self.enter(State::OperationEnabled);
            return;
        }
        *progress = alignment.tick(&Observed {
            position,
            ahead: inputs.electrical.ahead,
            voltage: inputs.electrical.voltage.map_or(0.0, |[_, along]| along),
            current: inputs.current,
            supply_voltage: inputs.supply_voltage,
            free: alignment.has_risen() && self.brake.release(),
        });
        if *progress == Progress::Failed {
            self.commutation.failed = true;
            self.commutation.abort();
        }
    }
}
