//! Newest readings of the sensors on the robot's body, from the task that reads them to the control
//! tick.

use core::cell::Cell;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_time::Instant;
use tautrack::sensors::{BodySensors, Fresh};

/// Newest readings.
pub struct Newest(Mutex<CriticalSectionRawMutex, Cell<State>>);

#[derive(Clone, Copy)]
struct State {
    /// `None` before the first reading.
    readings: Option<BodySensors>,
    /// When the control tick has last taken the readings; `None` before it did.
    taken: Option<Instant>,
}

impl Newest {
    /// No readings.
    pub(crate) const fn new() -> Self {
        Self(Mutex::new(Cell::new(State {
            readings: None,
            taken: None,
        })))
    }

    /// Takes new readings over: `change` writes them and marks them as fresh.
    pub(super) fn put(&self, change: impl FnOnce(&mut BodySensors)) {
        self.0.lock(|newest| {
            let mut state = newest.get();
            change(state.readings.get_or_insert(BodySensors {
                fresh: Fresh::NONE,
                ..BodySensors::default()
            }));
            newest.set(state);
        });
    }

    /// Returns the newest readings; those are fresh that came since the previous call. `None`
    /// before the first reading.
    pub fn take(&self) -> Option<BodySensors> {
        let now = Instant::now();
        self.0.lock(|newest| {
            let mut state = newest.get();
            let taken = state.readings;
            state.taken = Some(now);
            if let Some(readings) = &mut state.readings {
                readings.fresh = Fresh::NONE;
            }
            newest.set(state);
            taken
        })
    }

    /// Returns when the control tick has last taken the readings; `None` before it did.
    pub(super) fn taken(&self) -> Option<Instant> {
        self.0.lock(|newest| newest.get().taken)
    }
}
