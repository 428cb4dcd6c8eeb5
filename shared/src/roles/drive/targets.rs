//! Targets of a drive that no longer count. A target counts for the operation for which it was
//! written: enabling a drive, or changing its mode, never moves it to an old place or with an old
//! speed.

use super::super::axle::{OBJECT60FF, OBJECT607A, OBJECT6060, OBJECT6064, OBJECT6071};
use crate::bus::cia402::mode;
use crate::bus::node::Values;

/// Targets, as bits.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub(super) struct Targets(u8);

impl Targets {
    const TORQUE: Self = Self(1);
    const POSITION: Self = Self(2);
    const VELOCITY: Self = Self(4);

    /// The target that this object holds, if it is one.
    pub fn of(index: u16) -> Self {
        match index {
            0x6071 => Self::TORQUE,
            0x607a => Self::POSITION,
            0x60ff => Self::VELOCITY,
            _ => Self::default(),
        }
    }

    /// Adds others.
    pub fn add(&mut self, others: Self) {
        self.0 |= others.0;
    }

    fn has(self, target: Self) -> bool {
        self.0 & target.0 != 0
    }
}

/// Which targets count.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Memory {
    /// Targets that count.
    known: Targets,
    operating: bool,
    mode: i8,
    circumstances: Circumstances,
}

/// Who commands the drive, and whether it has faults.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Circumstances {
    pub bench: bool,
    pub guarded: bool,
    pub faulty: bool,
}

impl Memory {
    /// Takes over the targets that were `written` since the last tick. A change of mode forgets the
    /// others. Before operation, the target position is the present one, and the slack 0, until a
    /// client writes it.
    pub fn begin_tick<const N: usize>(&mut self, written: Targets, values: &mut Values<N>) {
        let mode = values.get(OBJECT6060);
        let changes = mode != self.mode;
        if changes {
            self.known = Targets::default();
        }
        self.known.add(written);
        if !self.operating || changes {
            self.forget_unknown(values);
        }
        self.mode = mode;
    }

    /// Ends a tick after which the drive operates, or does not. The end of operation forgets all
    /// targets, and so does a change of who commands or of the faults while it does not operate.
    pub fn end_tick<const N: usize>(
        &mut self,
        operating: bool,
        circumstances: Circumstances,
        values: &mut Values<N>,
    ) {
        let changed = core::mem::replace(&mut self.circumstances, circumstances) != circumstances;
        if !operating && (self.operating || changed) {
            self.known = Targets::default();
            self.forget_unknown(values);
        }
        self.operating = operating;
    }

    /// Whether the drive operated after the last tick.
    pub fn operating(self) -> bool {
        self.operating
    }

    fn forget_unknown<const N: usize>(self, values: &mut Values<N>) {
        if !self.known.has(Targets::POSITION) {
            // In this mode the target is a slack: none.
            let released = values.get(OBJECT6060) == mode::RELEASED;
            let target = if released { 0 } else { values.get(OBJECT6064) };
            values.set(OBJECT607A, target);
        }
        if !self.known.has(Targets::VELOCITY) {
            values.set(OBJECT60FF, 0);
        }
        if !self.known.has(Targets::TORQUE) {
            values.set(OBJECT6071, 0);
        }
    }
}
